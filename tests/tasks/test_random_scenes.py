"""Random scenes are new, within bounds, and the same for the same seed."""

import numpy as np
import pytest

from sbam.tasks import random_pouring_scene, random_rolling_scene
from sbam.tasks.pouring.scenes import DEMONSTRATED, DIFFERENT

SEEDS = range(40)


def at(scene, name) -> np.ndarray:
    return (scene.T_world_agent.inv() * scene.T_world_object[name]).translation


def standing(scene, name) -> np.ndarray:
    """(A, 3) regions of an object in the agent frame."""
    pose = scene.T_world_agent.inv() * scene.T_world_object[name]
    return np.array([pose.apply(region.center) for region in scene.objects[name].affordance_regions])


def test_pouring_scenes_are_new_layouts_on_the_table():
    offsets = []
    for seed in SEEDS:
        scene = random_pouring_scene(seed)
        assert set(scene.objects) == {"kitchen_sideboard", "cup_large", "apple_juice"} == set(scene.T_world_object)
        cup, bottle = at(scene, "cup_large"), at(scene, "apple_juice")
        offsets.append((bottle - cup)[:2])
        assert np.linalg.norm(DEMONSTRATED - offsets[-1], axis=1).min() > DIFFERENT
        assert 0.18 <= np.linalg.norm(offsets[-1]) <= 0.38
        for name in ("cup_large", "apple_juice"):
            regions = standing(scene, name)
            assert regions[:, 2].min() == pytest.approx(0.0, abs=1e-9)  # `place` on the table
            np.testing.assert_allclose(np.ptp(regions[:, :2], axis=0), 0.0, atol=1e-9)  # upright
        assert standing(scene, "kitchen_sideboard")[0, 2] == pytest.approx(0.0, abs=1e-9)
    assert np.ptp(offsets, axis=0).min() > 0.15


def test_other_objects_take_their_places():
    scene = random_pouring_scene(3, bottle="milk_small", cup="cup_small")
    other = random_pouring_scene(3)
    np.testing.assert_array_equal(at(scene, "milk_small"), at(other, "apple_juice"))
    np.testing.assert_array_equal(at(scene, "cup_small"), at(other, "cup_large"))


def test_rolling_scenes_have_the_pin_across_the_table():
    for seed in SEEDS:
        scene = random_rolling_scene(seed)
        left, right = standing(scene, "rolling_pin")
        middle = 0.5 * (left + right)
        assert abs(middle[0]) <= 0.10
        assert 0.52 <= middle[1] <= 0.58
        np.testing.assert_allclose([left[2], right[2]], 0.033, atol=1e-9)
        assert right[0] - left[0] > 0.4 * np.cos(np.deg2rad(10.0)) - 1e-9


@pytest.mark.parametrize("make", [random_pouring_scene, random_rolling_scene])
def test_seeds_decide(make):
    first, again, other = make(5), make(5), make(6)
    moved = next(name for name, model in first.objects.items() if model.movable)
    np.testing.assert_array_equal(first.T_world_object[moved].as_matrix(), again.T_world_object[moved].as_matrix())
    assert np.abs(first.T_world_object[moved].as_matrix() - other.T_world_object[moved].as_matrix()).max() > 1e-3
    assert first.name != other.name
