"""A scene is planned from the demonstrations whose order fits its layout; the file keeps what is needed for that."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

import sbam
from sbam.learning.variants import nearest_layout
from sbam.planning.variant import choose_variant

DEMONSTRATIONS = sbam.built_in_demonstrations("pouring")
LEFT = {demonstration.name for demonstration in DEMONSTRATIONS if "left" in demonstration.name}


@pytest.fixture(scope="module")
def model():
    return sbam.learn(DEMONSTRATIONS)


@pytest.fixture(scope="module")
def scene():
    return sbam.load_scene("built-in:pouring_new_layout")


def names(model):
    return {demonstration.name for demonstration in model.demonstrations}


@pytest.mark.parametrize("demonstration", DEMONSTRATIONS, ids=lambda demonstration: demonstration.name)
def test_each_layout_finds_its_own_order(model, demonstration):
    variant, (note,) = choose_variant(model, sbam.scene_from_demonstration(demonstration))
    assert (demonstration.name in LEFT) == (names(variant) == LEFT)
    assert demonstration.name in names(variant)
    assert str(len(variant.demonstrations)) in note
    assert demonstration.name in note


def test_a_variant_is_what_its_demonstrations_alone_would_teach(model, scene):
    variant, _ = choose_variant(model, scene)
    alone = sbam.learn([d for d in DEMONSTRATIONS if d.name in names(variant)])
    assert len(variant.demonstrations) < len(model.demonstrations)
    np.testing.assert_array_equal(variant.keypoint_times, alone.keypoint_times)
    assert variant.anchors == alone.anchors
    for one, other in zip(variant.changes, alone.changes, strict=True):
        assert one.pair == other.pair
        for mine, theirs in zip(one.channels, other.channels, strict=True):
            np.testing.assert_array_equal(mine.mean, theirs.mean)


def test_only_the_layout_counts_not_where_it_stands(model, scene):
    away = RigidTransform.from_translation([0.4, -0.2, 0.1])
    poses = {name: away * pose for name, pose in scene.T_world_object.items()}
    moved = replace(scene, T_world_object=poses)
    assert names(choose_variant(model, moved)[0]) == names(choose_variant(model, scene)[0])


def test_it_can_be_switched_off_and_needs_what_it_compares(model, scene):
    off = sbam.learn(DEMONSTRATIONS, settings=replace(model.settings, variants=False))
    assert off.variants == ()
    assert choose_variant(off, scene) == (off, ())
    kept = tuple(replace(s, roles=tuple(replace(role, start=None) for role in s.roles)) for s in model.demonstrations)
    earlier = replace(model, demonstrations=kept)  # a model that an earlier version wrote
    assert choose_variant(earlier, scene)[0] is earlier


def test_one_object_has_no_layout():
    rolling = sbam.learn(sbam.built_in_demonstrations("rolling"))
    assert nearest_layout(rolling.demonstrations, {}) is None
    assert choose_variant(rolling, sbam.load_scene("built-in:rolling"))[0] is rolling


def test_pruning_is_of_the_demonstrations_that_fit_the_scene(model):
    scene = sbam.load_scene("built-in:synthetic_pouring_juice_left_6")
    (whole, notes), (small, more) = choose_variant(model, scene), choose_variant(model, scene, prune=0.75)
    kept, dropped = {str(c.pair) for c in small.changes}, {str(c.pair) for c in whole.changes}
    dropped -= kept
    assert "pour from of pour_from -> pour into of pour_into" in kept and dropped
    assert more[:-1] == notes
    assert more[-1].endswith(f"pairs pruned: {', '.join(sorted(dropped))}")
    assert choose_variant(model, scene, prune=0.0)[1] == notes


def test_a_file_keeps_the_variants_and_where_things_stood(model, scene, tmp_path):
    sbam.save_model(model, tmp_path / "model.json")
    read = sbam.load_model(tmp_path / "model.json")
    variant, again = choose_variant(model, scene)[0], choose_variant(read, scene)[0]
    assert names(again) == names(variant)
    np.testing.assert_array_equal(again.keypoint_times, variant.keypoint_times)
    for sketched, demonstration in zip(read.demonstrations, DEMONSTRATIONS, strict=True):
        for role in sketched.roles:
            pose = demonstration.T_world_agent.inv() * demonstration.T_world_object[role.object][0]
            object_model = sbam.ObjectLibrary.built_in()[role.object]
            centers = np.array([object_model.region(affordance).center for affordance in role.affordances])
            assert role.start is not None
            np.testing.assert_allclose(role.start, pose.apply(centers))
