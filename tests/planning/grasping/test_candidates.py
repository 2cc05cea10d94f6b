"""Candidates have the geometry they promise."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.demonstrations.scenes import starting_scene
from sbam.errors import UnreachableError
from sbam.planning.bind import bind
from sbam.planning.grasping.candidates import AZIMUTHS, DEPTHS, HEIGHTS, TILTS_ACROSS, TILTS_AROUND, candidate_grasps
from sbam.planning.task import MovedObject
from sbam.robots import CollisionModel

UP = np.array([0.0, 0.0, 1.0])


@pytest.fixture(scope="module")
def objects(model_of) -> dict[str, MovedObject]:
    tasks = [
        bind(model_of("pouring"), starting_scene("built-in:pouring_new_layout")),
        bind(model_of("rolling"), starting_scene("built-in:rolling")),
    ]
    return {moved.name: moved for task in tasks for moved in task.moved}


@pytest.fixture(scope="module")
def candidates(panda):
    def find(moved: MovedObject, hand):
        return candidate_grasps(panda, CollisionModel(panda, {moved.name: moved.model}), moved, hand)

    return find


def directions(robot, moved, grasp) -> tuple[RigidTransform, np.ndarray, np.ndarray]:
    """Pose of the TCP at the object's start, its approach and opening directions, agent frame."""
    tcp = moved.start * grasp.T_object_tcp
    hand = robot.arms[grasp.hand].hand
    return tcp, tcp.rotation.apply(hand.approach), tcp.rotation.apply(hand.opening)


@pytest.mark.parametrize("name", ["cup_large", "apple_juice"])
@pytest.mark.parametrize("hand", ["left", "right"])
def test_vessels_are_held_around_their_axis(panda, objects, candidates, name, hand):
    moved = objects[name]
    (region,) = moved.model.grasp_regions
    grasps = candidates(moved, hand)
    assert grasps
    for grasp in grasps:
        tcp, approach, opening = directions(panda, moved, grasp)
        horizontal = np.array([-np.sin(grasp.azimuth), np.cos(grasp.azimuth), 0.0])
        np.testing.assert_allclose(approach, np.cos(grasp.tilt) * horizontal - np.sin(grasp.tilt) * UP, atol=1e-9)
        # The fingers close across the axis, horizontally.
        np.testing.assert_allclose([opening @ approach, opening @ UP], 0.0, atol=1e-9)
        # The TCP stays short of a point on the axis by the depth.
        on_axis = moved.start.inv().apply(tcp.translation + grasp.depth * approach) - region.center
        along = on_axis @ region.axis
        np.testing.assert_allclose(on_axis, along * region.axis, atol=1e-9)
        assert np.abs(along / region.half_length - np.array(HEIGHTS)).min() < 1e-9
        assert grasp.depth in DEPTHS
        assert grasp.tilt in TILTS_AROUND
        assert (grasp.role, grasp.hand, grasp.region, grasp.width) == (moved.role, hand, region.name, region.width)
    assert len({grasp.tilt for grasp in grasps}) > 1


def test_a_flipped_hand_is_turned_by_half_a_turn_about_its_approach(panda, objects, candidates):
    for name in objects:
        hand = objects[name].hands[0]
        by_flip = {False: [], True: []}
        for grasp in candidates(objects[name], hand):
            by_flip[grasp.flipped].append(grasp)
        assert len(by_flip[False]) == len(by_flip[True]) > 0
        for straight, flipped in zip(by_flip[False], by_flip[True], strict=True):
            tcp, approach, opening = directions(panda, objects[name], straight)
            other, other_approach, other_opening = directions(panda, objects[name], flipped)
            np.testing.assert_allclose(other.translation, tcp.translation, atol=1e-12)
            np.testing.assert_allclose(other_approach, approach, atol=1e-12)
            np.testing.assert_allclose(other_opening, -opening, atol=1e-12)
            half_a_turn = Rotation.from_rotvec(np.pi * approach) * tcp.rotation
            assert (other.rotation * half_a_turn.inv()).magnitude() < 1e-6


def test_round_vessels_are_approached_from_anywhere(objects, candidates):
    azimuths = {round(float(grasp.azimuth), 9) for grasp in candidates(objects["cup_large"], "left")}
    assert azimuths == {round(float(azimuth), 9) for azimuth in AZIMUTHS}


@pytest.mark.parametrize("yaw_deg", [0.0, 20.0, -75.0])
def test_square_bottles_are_approached_towards_their_faces(panda, objects, candidates, yaw_deg):
    moved = objects["apple_juice"]
    turned = RigidTransform.from_components(
        moved.start.translation, Rotation.from_euler("z", yaw_deg, degrees=True) * moved.start.rotation
    )
    moved = replace(moved, start=turned)
    grasps = candidates(moved, "right")
    assert len({round(float(grasp.azimuth), 6) for grasp in grasps}) == 4
    for grasp in grasps:
        opening = grasp.T_object_tcp.rotation.apply(panda.arms["right"].hand.opening)
        # In the bottle's frame, +y up, faces along x and z.
        np.testing.assert_allclose(np.sort(np.abs(opening)), [0.0, 0.0, 1.0], atol=1e-9)
        assert abs(opening[1]) < 1e-9


def test_bars_are_held_from_above(panda, objects, candidates):
    pin = objects["rolling_pin"]
    lying = replace(pin, start=RigidTransform.from_translation([0.0, 0.5, 0.033]))  # +x to the right
    for hand, x in (("left", -0.205), ("right", 0.205)):
        grasps = candidates(lying, hand)
        assert {grasp.tilt for grasp in grasps} <= set(TILTS_ACROSS)
        for grasp in grasps:
            tcp, approach, opening = directions(panda, lying, grasp)
            assert grasp.region == f"handle {hand}"
            np.testing.assert_allclose(approach, [0.0, np.sin(grasp.tilt), -np.cos(grasp.tilt)], atol=1e-9)
            np.testing.assert_allclose(tcp.translation + grasp.depth * approach, [x, 0.5, 0.033], atol=1e-9)
            np.testing.assert_allclose([opening @ approach, opening[0]], 0.0, atol=1e-9)


@pytest.mark.parametrize("yaw_deg", [90.0, -90.0])
def test_a_bar_that_points_forward_is_leant_over_too(panda, objects, candidates, yaw_deg):
    rotation = Rotation.from_euler("z", yaw_deg, degrees=True)
    lying = replace(objects["rolling_pin"], start=RigidTransform.from_components([0.0, 0.5, 0.033], rotation))
    grasps = candidates(lying, "left")
    for grasp in grasps:
        _, approach, _ = directions(panda, lying, grasp)
        assert approach[2] == pytest.approx(-np.cos(grasp.tilt))
    assert len({grasp.tilt for grasp in grasps}) > 1


def test_the_palm_stays_clear_of_what_the_fingers_hold(panda, objects, candidates):
    """By MuJoCo's distances between the palm's body and the object, the arm being at home and the object brought."""
    for moved in objects.values():
        hand = moved.hands[0]
        palm = panda.arms[hand].hand.body
        collision = CollisionModel(panda, {moved.name: moved.model})
        home = panda.kinematics(panda.home[None], [panda.arms[hand].tcp_frame])
        T_agent_tcp = RigidTransform.from_components(home.position[0, 0], Rotation.from_matrix(home.rotation[0, 0]))
        grasps = candidates(moved, hand)[::7]
        poses = RigidTransform.concatenate([T_agent_tcp * grasp.T_object_tcp.inv() for grasp in grasps])
        near = collision.near(np.tile(panda.home, (len(grasps), 1)), {moved.name: poses}, margin=0.0)
        pairs = {frozenset(pair) for pair in zip(near.first, near.second, strict=True)}
        assert frozenset((moved.name, palm)) not in pairs


def test_peoples_azimuths_rank(objects, candidates):
    """A person's hand to the right of the cup held it towards the left: 90 degrees."""
    moved = replace(objects["cup_large"], human_grasps={"left": np.array([[0.08, 0.0, 0.06], [0.09, 0.0, 0.05]])})
    for grasp in candidates(moved, "left"):
        away = np.abs((grasp.azimuth - np.pi / 2 + np.pi) % (2 * np.pi) - np.pi)
        assert grasp.human_distance == pytest.approx(away)
    unseen = replace(moved, human_grasps={"left": np.zeros((0, 3))})
    assert {grasp.human_distance for grasp in candidates(unseen, "left")} == {0.0}


def test_too_wide_objects_are_named_with_their_sizes(objects, candidates):
    moved = objects["cup_large"]
    regions = tuple(replace(region, width=0.1) for region in moved.model.grasp_regions)
    wide = replace(moved, model=replace(moved.model, grasp_regions=regions))
    with pytest.raises(UnreachableError, match=r"'cup_large'.*right hand \(opens 80 mm\): 'body' \(100 mm"):
        candidates(wide, "right")
    without = replace(moved, model=replace(moved.model, grasp_regions=()))
    with pytest.raises(UnreachableError, match=r"opens 80 mm\): none"):
        candidates(without, "right")


@pytest.mark.parametrize(
    "tipped", [Rotation.from_euler("x", 90, degrees=True), Rotation.from_euler("y", 90, degrees=True)]
)
def test_lying_vessels_and_standing_bars_give_finite_grasps_or_say_so(objects, candidates, tipped):
    for moved in objects.values():
        lying = RigidTransform.from_components(moved.start.translation, tipped)
        try:
            grasps = candidates(replace(moved, start=lying), moved.hands[0])
        except UnreachableError:
            continue
        assert all(np.isfinite(grasp.T_object_tcp.as_matrix()).all() for grasp in grasps)
