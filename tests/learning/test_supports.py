"""Pairs against a table are measured from the person before it."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from sbam.errors import DemonstrationError
from sbam.learning.learn import add_demonstration, learn
from sbam.learning.settings import LearningSettings
from sbam.scene.object_library import ObjectLibrary


def support_changes(model):
    return [c for c in model.changes if c.pair.second and c.pair.second.affordance == "place onto"]


def moved_table(demonstration, index):
    """The same demonstration with the table elsewhere below the things."""
    shift = RigidTransform.from_translation([0.05 * index, -0.03 * index, 0.0])
    poses = dict(demonstration.T_world_object)
    poses["kitchen_sideboard"] = shift * poses["kitchen_sideboard"]
    return replace(demonstration, T_world_object=poses)


@pytest.mark.parametrize("constraint", ["cartesian", "cylindrical", "symbolic"])
def test_the_middle_of_the_table_does_not_matter(rolling, constraint):
    model = learn(rolling[:4], constraint)
    elsewhere = learn(
        [moved_table(demonstration, index) for index, demonstration in enumerate(rolling[:4])], constraint
    )
    for one, other in zip(support_changes(model), support_changes(elsewhere), strict=True):
        assert one.constraint == "cartesian"
        assert one.from_agent
        for mine, theirs in zip(one.channels, other.channels, strict=True):
            np.testing.assert_allclose(mine.mean, theirs.mean, atol=1e-9)
            np.testing.assert_allclose(mine.std, theirs.std, atol=1e-9)


def test_it_starts_where_the_object_stood_in_the_agent_frame(rolling):
    demonstration = rolling[0]
    model = learn([demonstration])
    pin = demonstration.T_world_agent.inv() * demonstration.T_world_object["rolling_pin"][0]
    for change in support_changes(model):
        region = model.demonstrations[0].region_at_start(change.pair.first)
        assert region is not None
        np.testing.assert_allclose(change.at(np.zeros(1))[0][0, :2], region[:2], atol=1e-9)
        assert np.linalg.norm(region - pin.translation) == pytest.approx(0.2, abs=0.05)


@pytest.mark.parametrize(
    "settings",
    [
        LearningSettings.paper(),
        replace(LearningSettings(), supports="center"),
    ],
    ids=["paper", "center"],
)
def test_others_measure_from_the_centre(rolling, settings):
    model = learn(rolling[:2], settings=settings)
    shifted = learn([moved_table(demonstration, 1) for demonstration in rolling[:2]], settings=settings)
    found = support_changes(model)
    assert found
    for one, other in zip(found, support_changes(shifted), strict=True):
        assert not one.from_agent
        assert abs(one.channels[0].mean[0] - other.channels[0].mean[0]) > 0.01


def test_a_board_that_can_be_moved_is_an_object_like_others(pouring):
    library = ObjectLibrary.built_in()
    board = {
        **{name: library[name] for name in library},
        "kitchen_sideboard": replace(library["kitchen_sideboard"], movable=True),
    }
    model = learn(pouring[:2], library=board)
    assert not any(change.from_agent for change in model.changes)
    with pytest.raises(DemonstrationError, match=r"juice_right_away_3.*place onto.*support can be moved"):
        add_demonstration(model, pouring[3])
