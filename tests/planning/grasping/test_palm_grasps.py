"""Hands with palms: candidates have the geometry they promise, and both ARMARs do the built-in tasks with them."""

import numpy as np
import pytest

from sbam.demonstrations.scenes import starting_scene
from sbam.planning.bind import bind
from sbam.planning.grasping.candidates import (
    LAID_ON,
    PALM_CLEARANCE,
    PALM_HEIGHTS,
    TILTS_AROUND,
    TILTS_PALM_DOWN,
    candidate_grasps,
)
from sbam.planning.plan import plan
from sbam.planning.task import MovedObject
from sbam.robots import CollisionModel, Robot, load_robot

UP = np.array([0.0, 0.0, 1.0])
HALF_PALM = 0.02  # m from the tool centre point to the palm's surface, of both robots
SCENES = {"pouring": "built-in:pouring_new_layout", "rolling": "built-in:rolling"}


@pytest.fixture(scope="module")
def objects(model_of) -> dict[str, MovedObject]:
    tasks = [bind(model_of(task), starting_scene(scene)) for task, scene in SCENES.items()]
    return {moved.name: moved for task in tasks for moved in task.moved}


@pytest.fixture(scope="module", params=["armar6", "armar7"])
def armar(request) -> Robot:
    return load_robot(request.param)


@pytest.fixture(scope="module")
def candidates(armar):
    def find(moved: MovedObject, hand):
        return candidate_grasps(armar, CollisionModel(armar, {moved.name: moved.model}), moved, hand)

    return find


def directions(moved, grasp):
    """Pose of the TCP at the object's start, palm's normal, fingers' and thumb's direction, agent frame."""
    tcp = moved.start * grasp.T_object_tcp
    normal, fingers = tcp.rotation.apply([0, 1, 0]), tcp.rotation.apply([0, 0, 1])
    thumb = tcp.rotation.apply([1, 0, 0]) * (1 if grasp.hand == "left" else -1)
    return tcp, normal, fingers, thumb


@pytest.mark.parametrize("name", ["cup_large", "apple_juice"])
@pytest.mark.parametrize("hand", ["left", "right"])
def test_vessels_are_held_thumb_up_and_fingers_down(objects, candidates, name, hand):
    moved = objects[name]
    (region,) = moved.model.grasp_regions
    grasps = candidates(moved, hand)
    assert {grasp.tilt for grasp in grasps} == set(TILTS_AROUND)
    assert len({grasp.azimuth for grasp in grasps}) == (region.faces or 12) and not any(
        grasp.flipped for grasp in grasps
    )
    for grasp in grasps:
        tcp, normal, fingers, thumb = directions(moved, grasp)
        np.testing.assert_allclose(normal, [-np.sin(grasp.azimuth), np.cos(grasp.azimuth), 0.0], atol=1e-9)
        np.testing.assert_allclose([fingers @ UP, thumb @ UP], [-np.sin(grasp.tilt), np.cos(grasp.tilt)], atol=1e-9)
        on_axis = moved.start.inv().apply(tcp.translation + grasp.depth * normal) - region.center
        along = on_axis @ region.axis
        np.testing.assert_allclose(on_axis, along * region.axis, atol=1e-9)
        assert np.abs(along / region.half_length - np.array(PALM_HEIGHTS)).min() < 1e-9
        # the palm lies against the object: not in it, and not far from it
        gap = grasp.depth - HALF_PALM - region.width / 2
        assert PALM_CLEARANCE - 1e-9 <= gap <= PALM_CLEARANCE + LAID_ON


@pytest.mark.parametrize("hand", ["left", "right"])
def test_bars_are_held_palm_down_with_the_thumbs_inwards(objects, candidates, hand):
    moved = objects["rolling_pin"]
    grasps = candidates(moved, hand)
    assert {grasp.region for grasp in grasps} == {f"handle {hand}"}
    assert {grasp.tilt for grasp in grasps} == set(TILTS_PALM_DOWN)
    inwards = 1 if hand == "left" else -1
    for grasp in grasps:
        _, normal, fingers, thumb = directions(moved, grasp)
        assert normal @ UP < -0.7 and fingers[1] > 0.7 and inwards * thumb[0] > 0.9
        np.testing.assert_allclose(fingers @ UP, -np.sin(grasp.tilt), atol=0.02)
        # on the handle (radius 14 mm), not on the thicker pin beside it (33 mm)
        assert grasp.depth < 0.014 + HALF_PALM + PALM_CLEARANCE + 0.01


def test_the_built_in_tasks_are_done(armar, model_of):
    for task, scene in SCENES.items():
        found = plan(model_of(task), starting_scene(scene), armar)
        assert found.ok, found.problems
        assert found.trajectory.joint_names == armar.joint_names
