"""Where the base, or the objects, would have to be."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from sbam.demonstrations.scenes import starting_scene
from sbam.planning.bind import bind
from sbam.planning.placement.report import base_option, base_report, sentences
from sbam.planning.placement.room import has_room, stay_on_their_supports
from sbam.planning.placement.search import BaseMap, reach_where_it_stands, search_base, shifted
from sbam.planning.plan import plan
from sbam.robots import load_robot
from sbam.tasks import random_pouring_scene

GRID = {"right": np.array([0.0]), "forward": np.array([-0.2, 0.0, 0.2, 0.35]), "turn": np.array([0.0])}


FAR = "panda_dual:forward=-0.4"


@pytest.fixture(scope="module")
def scene():
    return starting_scene("built-in:rolling")


@pytest.fixture(scope="module")
def found(model_of, scene) -> BaseMap:
    """Two Pandas that stand 40 cm farther back than usual."""
    return search_base(model_of("rolling"), scene, FAR, **GRID)


def test_it_says_how_far_and_where_to(found):
    """The places it recommends are planned for."""
    assert not found.here.planned
    assert found.base is not None and found.base.planned and found.base.reaches
    assert found.objects is not None and found.objects.planned
    assert 0 < found.base.forward <= 0.35
    assert -0.35 <= found.objects.forward < 0
    assert 0.002 < max(found.here.miss.values()) < 0.4
    assert found.miss.shape == (1, 4, 1)
    assert (np.diff(found.miss[0, :, 0]) <= 0).all()  # nearer is better


def test_what_it_recommends_works_as_it_says(found, model_of, scene):
    robot = base_option(found, found.base)
    assert robot == f"panda_dual:forward={found.base.forward - 0.4:.6g}"
    assert plan(model_of("rolling"), scene, robot).ok
    assert plan(model_of("rolling"), shifted(scene, found.objects.right, found.objects.forward), FAR).ok


def test_sentences(found):
    said = sentences(found)
    assert any(f"--robot {base_option(found, found.base)}" in sentence for sentence in said)
    assert "farther back" in said[-1]
    assert base_report(found)["ok"] is False
    nothing = sentences(replace(found, base=None, objects=None))
    assert "no place of its base" in nothing[-2]
    assert "no shift" in nothing[-1]
    doubtful = sentences(replace(found, base=replace(found.base, planned=False)))
    assert "no plan passed" in doubtful[-2]


def test_options_add_up(found):
    """What the robot was given already is kept and counted in."""
    robot = load_robot("panda_dual:base_distance=0.9,forward=0.1").placed_for(RigidTransform.identity())
    place = replace(found.base, right=0.0, forward=0.15, turn=-10.0)
    assert base_option(replace(found, robot=robot), place) == "panda_dual:base_distance=0.9,forward=0.25,turn=-10"


def test_room(model_of, scene):
    """ARMAR-6's platform fits under the table top, its torso does not; beside and behind there is room."""
    task = bind(model_of("rolling"), scene)
    robot = load_robot("armar6").placed_for(RigidTransform.identity())
    steps = np.array([[0, 0, 0], [0, 0.55, 0], [0, -0.5, 0], [3, 0.55, 0]])
    bases = RigidTransform.from_components(robot.T_world_base.translation + steps, robot.T_world_base.rotation)
    np.testing.assert_array_equal(has_room(robot, task, bases), [True, False, True, True])


def test_objects_stay_on_the_table(model_of, scene):
    task = bind(model_of("rolling"), scene)
    shifts = np.array([[0, 0], [0, -0.2], [0, -0.6], [0, 0.5], [3, 0]])
    np.testing.assert_array_equal(stay_on_their_supports(task, shifts), [True, True, False, False, False])


def test_by_how_much_a_hand_misses(model_of):
    """In this scene ARMAR-7's right arm is at the end of its reach; 10 cm farther back it misses about as much."""
    scene = random_pouring_scene(5)
    place = reach_where_it_stands(model_of("pouring"), scene, "armar7:forward=-0.1")
    missed = {hand: miss for (_, hand), miss in place.miss.items()}
    assert 0.05 < missed["right"] < 0.2
    assert not place.reaches
    assert place.planned is None
    assert reach_where_it_stands(model_of("pouring"), scene, "panda_dual").reaches
