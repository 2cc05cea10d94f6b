from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from sbam.constraints import CONSTRAINT_TYPES
from sbam.constraints.base import wrap
from sbam.demonstrations.readers import read_demonstration, read_demonstrations
from sbam.errors import DemonstrationError, UnknownNameError
from sbam.learning import LearningSettings, add_demonstration, learn
from sbam.learning.sketch import constraint_values
from sbam.scene.object_library import ObjectLibrary

TYPES = pytest.mark.parametrize("constraint", list(CONSTRAINT_TYPES))
MODES = pytest.mark.parametrize("mode", ["default", "paper"])


def vector(demonstration, pair, objects, mode="default"):
    """The pair's vector over time, computed here once more, (T, 3); in the plane of a support from the agent."""
    library = ObjectLibrary.built_in()

    def position(region):
        name = objects[region.role]
        point = demonstration.T_world_object[name].apply(library[name].region(region.affordance).center)
        return demonstration.T_world_agent.inv().apply(point)

    first = position(pair.first)
    second = first[0] if pair.second is None else position(pair.second)
    if mode == "default" and pair.second is not None and pair.second.affordance == "place onto":
        second = second * [0.0, 0.0, 1.0]
    return first - second


def same_model(one, other):
    assert one.roles == other.roles and one.anchors == other.anchors
    np.testing.assert_array_equal(one.keypoint_times, other.keypoint_times)
    for change, again in zip(one.changes, other.changes, strict=True):
        assert (change.pair, change.constraint) == (again.pair, again.constraint)
        for channel, copy in zip(change.channels, again.channels, strict=True):
            for name in ("time", "mean", "std", "count"):
                np.testing.assert_array_equal(getattr(channel, name), getattr(copy, name))
    for hold, again in zip(one.holds, other.holds, strict=True):
        assert (hold.role, hold.hand, hold.grasp, hold.release) == (again.role, again.hand, again.grasp, again.release)
        np.testing.assert_array_equal(hold.hand_position, again.hand_position)


@TYPES
@MODES
def test_one_demonstration_is_its_own_polyline(pouring, constraint, mode):
    demonstration = pouring[0]
    model = learn([demonstration], constraint, mode)
    assert model.duration == pytest.approx(demonstration.duration)
    objects = {role.name: role.demonstrated[0] for role in model.roles}
    for change in model.changes:
        d = vector(demonstration, change.pair, objects, mode)
        values = constraint_values(change.constraint, d)
        for index, (channel, value) in enumerate(zip(change.channels, values.T, strict=True)):
            assert not channel.std.any()
            assert np.all(channel.count == 1)
            seen = np.stack([np.interp(channel.time, demonstration.time, d[:, axis]) for axis in range(3)], axis=-1)
            difference = channel.mean - CONSTRAINT_TYPES[change.constraint].channels(seen)[:, index]
            np.testing.assert_allclose(wrap(difference) if channel.unit == "rad" else difference, 0, atol=1e-9)
            if channel.unit == "m":
                line = np.interp(demonstration.time, channel.time, channel.mean)
                amplitude = max(np.ptp(value), 0.01)
                assert np.abs(line - value).mean() < 0.06 * amplitude


@TYPES
@MODES
def test_adding_gives_the_same_model_as_learning_at_once(pouring, constraint, mode):
    model = learn(pouring[7:9], constraint, mode, name="pour")
    for demonstration in pouring[9:11]:
        model = add_demonstration(model, demonstration)
    same_model(model, learn(pouring[7:11], constraint, mode, name="pour"))


def test_the_model_of_pouring(pouring):
    model = learn(pouring, name="pour")
    assert {role.name: role.moves for role in model.roles} == {
        "pour_from": True,
        "pour_into": True,
        "place_onto": False,
    }
    assert {role.name: role.demonstrated for role in model.roles}["pour_from"] == ("apple_juice", "milk_small")
    assert model.synthetic and model.name == "pour" and model.mode == "default"
    assert {hold.role: hold.hand for hold in model.holds} == {"pour_into": "left", "pour_from": "right"}
    assert all(hold.hand_position.shape == (12, 3) for hold in model.holds)
    assert {anchor.time for anchor in model.anchors} <= set(model.keypoint_times)
    assert 16 <= len(model.keypoint_times) <= 40
    anchor = {(a.kind, a.role): a.time for a in model.anchors}
    for hold in model.holds:
        assert 0 <= hold.grasp <= anchor["lift", hold.role] < anchor["place", hold.role] <= hold.release
    # While pouring the mouth is where it always is; before the lift it is where the layout put it.
    pour = next(c for c in model.changes if str(c.pair) == "pour from of pour_from -> pour into of pour_into")
    _, std = pour.at(np.linspace(0, model.duration, 200))
    spread = np.linalg.norm(std, axis=1)
    assert spread.min() < 0.03 < 0.15 < spread[0]


def test_the_model_of_rolling(rolling):
    model = learn(rolling)
    assert sorted(hold.hand for hold in model.holds) == ["left", "right"]
    assert sum(anchor.kind == "reversal" for anchor in model.anchors) >= 8
    strokes = next(c for c in model.changes if c.pair.is_own_start)
    mean, _ = strokes.at(np.linspace(0, model.duration, 500))
    turns = np.sum(np.diff(np.sign(np.diff(mean[:, 1]))) != 0)
    assert turns >= 8


def test_mean_and_std_agree_with_the_aligned_demonstrations(pouring):
    """Oracle: warp every demonstration by its own anchors and take numpy's moments on a grid."""
    from sbam.learning.anchors import align_events, warp

    demonstrations = pouring[:6]
    model = learn(demonstrations)
    anchors = align_events([s.events for s in model.demonstrations], [s.duration for s in model.demonstrations])
    grid = np.linspace(0, model.duration, 300)
    for change in model.changes:
        paths = []
        for own, demonstration, sketch in zip(anchors.times, demonstrations, model.demonstrations, strict=True):
            d = vector(demonstration, change.pair, {role.role: role.object for role in sketch.roles})
            at = warp(grid, anchors.mean_times, own)
            paths.append(np.stack([np.interp(at, demonstration.time, d[:, axis]) for axis in range(3)], axis=-1))
        mean, std = change.at(grid)
        amplitude = np.ptp(np.mean(paths, axis=0), axis=0).max()
        assert np.abs(mean - np.mean(paths, axis=0)).mean() < 0.04 * amplitude
        assert np.abs(std - np.std(paths, axis=0, ddof=1)).mean() < 0.04 * amplitude


def test_order_hardly_matters(pouring):
    grid = np.linspace(0, 1, 100)
    forth, back = learn(pouring[:6]), learn(pouring[:6][::-1])
    assert forth.duration == pytest.approx(back.duration)
    again = {change.pair: change for change in back.changes}
    for change in forth.changes:
        mean, _ = change.at(grid * forth.duration)
        other, _ = again[change.pair].at(grid * back.duration)
        assert np.abs(mean - other).mean() < 0.006


def test_paper_over_estimates_the_spread(pouring):
    exact = learn(pouring[:3], settings=replace(LearningSettings.paper(), update_rule="welford"))
    paper = learn(pouring[:3], mode="paper")
    assert not any(change.pair.is_own_start for change in paper.changes)
    assert [anchor.kind for anchor in paper.anchors] == ["start", "end"]
    assert not any(sketch.candidates for sketch in paper.demonstrations)
    for one, other in zip(paper.changes, exact.changes, strict=True):
        for channel, truth in zip(one.channels, other.channels, strict=True):
            assert channel.std.mean() >= truth.std.mean()


def test_progress_and_input_stay_untouched(pouring):
    calls = []
    before = pouring[0].T_world_object["apple_juice"].translation.copy()
    learn(pouring[:3], progress=lambda done, total: calls.append((done, total)))
    assert calls == [(1, 3), (2, 3), (3, 3)]
    np.testing.assert_array_equal(before, pouring[0].T_world_object["apple_juice"].translation)


def without(demonstration, *objects):
    kept = {name: poses for name, poses in demonstration.T_world_object.items() if name not in objects}
    return replace(demonstration, T_world_object=kept)


def test_a_demonstration_that_lacks_an_object_is_named(pouring):
    lacking = replace(without(pouring[1], "cup_large"), name="no cup")
    for order in ([pouring[0], lacking], [lacking, pouring[0]]):
        with pytest.raises(DemonstrationError, match=r"'no cup': lacks cup_large"):
            learn(order)
    with pytest.raises(DemonstrationError, match=r"'no cup'.*pour_into"):
        add_demonstration(learn([pouring[0]]), lacking)
    with pytest.raises(DemonstrationError, match=r"shows cup_large"):
        add_demonstration(learn([lacking], settings=replace(LearningSettings(), pairs="all")), pouring[0])


def with_other_name(demonstration, name, other):
    poses = dict(demonstration.T_world_object)
    poses[other] = poses.pop(name)
    return replace(demonstration, T_world_object=poses)


def test_a_pair_is_seen_alike_in_all_demonstrations(pouring):
    """The mouth of a carton is above its foot, that of a spoon beside its handle."""
    spoon = with_other_name(pouring[3], "apple_juice", "tablespoon")
    assert len(learn([pouring[0], spoon]).demonstrations) == 2
    for order in ([pouring[0], spoon], [spoon, pouring[0]]):
        with pytest.raises(
            DemonstrationError, match=r"pour from of pour_from -> place of pour_from.*built differently"
        ):
            learn(order, "cylindrical")
    settings = replace(LearningSettings.paper(), upright_as_cartesian=True)
    with pytest.raises(DemonstrationError, match=r"seen as cylindrical, in 'synthetic.*juice_right_0' as cartesian"):
        add_demonstration(learn([pouring[0]], "cylindrical", settings=settings), spoon)


@MODES
def test_further_affordances_of_a_later_object_do_not_count(pouring, mode):
    library = {name: ObjectLibrary.built_in()[name] for name in ObjectLibrary.built_in()}
    cup = library["cup_small"]
    bowl = replace(
        cup, affordance_regions=(replace(cup.affordance_regions[0], affordance="stir"), *cup.affordance_regions)
    )
    demonstrations = [pouring[0], pouring[10]]
    plain = learn(demonstrations, mode=mode, library=library)
    same_model(learn(demonstrations, mode=mode, library={**library, "cup_small": bowl}), plain)


def test_what_could_be_moved_must_be_movable(pouring):
    library = {name: ObjectLibrary.built_in()[name] for name in ObjectLibrary.built_in()}
    fixed = {**library, "cup_small": replace(library["cup_small"], movable=False)}
    with pytest.raises(DemonstrationError, match=r"milk_right_10.*pour_into.*cannot be moved"):
        learn([pouring[0], pouring[10]], library=fixed)


def test_nothing_to_learn(pouring):
    with pytest.raises(DemonstrationError, match="nothing to learn"):
        learn([])
    still = {
        name: RigidTransform.concatenate([poses[0]] * len(poses)) for name, poses in pouring[0].T_world_object.items()
    }
    with pytest.raises(DemonstrationError, match=r"none of its objects \(.*apple_juice.*\) moves"):
        learn([replace(pouring[0], T_world_object=still)])
    with pytest.raises(DemonstrationError, match="belong together"):
        learn([without(pouring[0], "apple_juice", "cup_large")])


def test_bad_recordings_are_refused(pouring):
    good = pouring[0]

    def cut(frames):
        objects = {name: poses[frames] for name, poses in good.T_world_object.items()}
        hands = {hand: poses[frames] for hand, poses in good.T_world_hand.items()}
        return replace(good, time=good.time[frames], T_world_object=objects, T_world_hand=hands)

    with pytest.raises(DemonstrationError, match=r"juice_right_0.*has 1 frame"):
        learn([cut(slice(0, 1))])
    with pytest.raises(DemonstrationError, match="times do not increase"):
        learn([replace(good, time=good.time[::-1])])
    with pytest.raises(DemonstrationError, match=r"cup_large has poses of shape \(5,\)"):
        learn(
            [replace(good, T_world_object={**good.T_world_object, "cup_large": good.T_world_object["cup_large"][:5]})]
        )
    cup = good.T_world_object["cup_large"]
    broken = cup.translation.copy()
    broken[17, 1] = np.nan
    lost = RigidTransform.from_translation(broken)
    with pytest.raises(DemonstrationError, match="pose of cup_large is not finite in frame 17"):
        add_demonstration(learn([good]), replace(good, T_world_object={**good.T_world_object, "cup_large": lost}))


def test_two_frames_are_enough_to_be_refused_or_learned_without_a_crash(pouring):
    good = pouring[0]
    few = slice(300, 420, 40)
    objects = {name: poses[few] for name, poses in good.T_world_object.items()}
    short = replace(good, time=good.time[few] - good.time[300], T_world_object=objects, T_world_hand={})
    for constraint in CONSTRAINT_TYPES:
        try:
            model = learn([short], constraint)
        except DemonstrationError:
            continue
        assert all(np.isfinite(channel.mean).all() for change in model.changes for channel in change.channels)


def test_unknown_names(pouring):
    with pytest.raises(UnknownNameError, match="constraint type 'polar'"):
        learn(pouring[:1], "polar")
    with pytest.raises(UnknownNameError, match=r"mode 'fast'.*'default', 'paper'"):
        learn(pouring[:1], mode="fast")
    with pytest.raises(UnknownNameError, match=r"unknown object 'cup_large' in demonstration 'synthetic.*moves"):
        learn(pouring[:1], library={})
    library = ObjectLibrary.built_in()
    without_table = {name: library[name] for name in library if name != "kitchen_sideboard"}
    model = learn(pouring[:1], library=without_table)
    assert any("kitchen_sideboard" in note and "left out" in note for note in model.notes)
    assert {role.name for role in model.roles} == {"pour_from", "pour_into"}


@TYPES
def test_the_real_recordings(recordings_folder, constraint):
    kit = recordings_folder / "kit_bimanual"
    pour = learn([read_demonstration(next(kit.glob("Pour_*.xml")))], constraint)
    assert not pour.synthetic
    assert {hold.role: hold.hand for hold in pour.holds} == {"pour_into": "left", "pour_from": "right"}
    roll = learn([read_demonstration(next(kit.glob("RollOut_*.xml")))], constraint)
    assert sum(anchor.kind == "reversal" for anchor in roll.anchors) >= 8
    assert len(roll.holds) == 2


def test_one_moving_object_without_hands(recordings_folder):
    recordings = read_demonstrations(sorted((recordings_folder / "mmlfd_pouring").glob("*.csv")))
    model = learn(recordings)
    assert {role.name for role in model.roles if role.moves} == {"pour_from"}
    (hold,) = model.holds
    assert hold.role == "pour_from" and hold.hand_position.shape == (0, 3)
    assert hold.grasp < hold.release


def test_a_demonstration_counts_once(pouring):
    demonstrations = pouring[:2]
    model = learn(demonstrations)
    with pytest.raises(DemonstrationError, match="is in the model already"):
        add_demonstration(model, demonstrations[0])
    with pytest.raises(DemonstrationError, match="is in the model already"):
        learn([*demonstrations, demonstrations[1]])


@pytest.mark.parametrize("kinds", [(), ("reversal",), ("tilt",), ("reversal", "tilt")])
def test_time_is_aligned_by_the_events_that_are_asked_for(pouring, rolling, kinds):
    settings = LearningSettings(alignment_events=kinds)
    found = {anchor.kind for task in (pouring, rolling) for anchor in learn(task[:3], settings=settings).anchors}
    assert found == {"start", "lift", "place", "end", *kinds}
