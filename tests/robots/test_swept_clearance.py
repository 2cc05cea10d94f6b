"""Clearances of whole motions: against every sample measured, on random motions."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import make_interp_spline
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.errors import ConfigurationError, UnknownNameError
from sbam.robots import PAIR_CLASSES, CollisionModel, Robot, load_robot
from sbam.robots.collision import Held
from sbam.robots.swept_clearance import STRIDE, swept_clearances
from sbam.scene import ObjectLibrary

LIBRARY = ObjectLibrary.built_in()
OBJECTS = {name: LIBRARY[name] for name in ("cup_large", "apple_juice", "kitchen_sideboard")}
UP = Rotation.from_euler("x", 90, degrees=True)
TABLE = RigidTransform.from_components([0, 0.54, -0.024], Rotation.from_euler("x", 180, degrees=True))
ROBOTS = ("panda_dual", "armar7")


@pytest.fixture(scope="module")
def models():
    robots = {name: load_robot(name) for name in ROBOTS}
    robots = {name: robot.placed_for(RigidTransform.identity()) for name, robot in robots.items()}
    return {name: (robot, CollisionModel(robot, OBJECTS)) for name, robot in robots.items()}


def random_motion(robot: Robot, count: int, seed: int) -> tuple[np.ndarray, dict[str, RigidTransform], Held, Held]:
    """Configurations; a cup that the left hand picks up, a bottle that floats about; when the hand may touch, holds."""
    generator = np.random.default_rng(seed)
    knots = robot.clip(robot.home + 0.5 * generator.standard_normal((6, len(robot.home))))
    q = robot.clip(make_interp_spline(np.linspace(0, 1, 6), knots, k=3)(np.linspace(0, 1, count)))
    frame = robot.kinematics(q, [robot.arms["left"].tcp_frame])
    tcp = RigidTransform.from_components(frame.position[:, 0], Rotation.from_matrix(frame.rotation[:, 0]))
    first, last = sorted(generator.integers(0, count, 2))
    sample = np.arange(count)
    cup = (tcp * RigidTransform.from_components(generator.normal(0, 0.05, 3), UP))[np.clip(sample, first, last)]
    begin, end = generator.uniform(-0.3, 0.3, (2, 3)) + np.array([0, 0.5, 0.2])
    places = np.linspace(begin, end, count)
    turns = Rotation.from_rotvec(np.linspace([0, 0, 0], generator.uniform(-2, 2, 3), count))
    poses = {"cup_large": cup, "apple_juice": RigidTransform.from_components(places, turns), "kitchen_sideboard": TABLE}
    touching = (sample >= first - count // 10) & (sample <= last + count // 10)
    return q, poses, {("cup_large", "left"): touching}, {("cup_large", "left"): (sample >= first) & (sample <= last)}


@settings(max_examples=20, deadline=None)
@given(name=st.sampled_from(ROBOTS), count=st.sampled_from([1, 2, STRIDE, 300, 901]), seed=st.integers(0, 10**6))
def test_as_if_every_sample_were_measured(models, name, count, seed):
    robot, collision = models[name]
    q, poses, held, rigid = random_motion(robot, count, seed)
    every = collision.clearances(q, poses, held, motions=1)
    found = swept_clearances(collision, q, poses, held, rigid)
    single = collision.clearances(q, poses, held)
    for kind in PAIR_CLASSES:
        exactly = pytest.approx(every.distance_by_class[kind][0], abs=1e-6)
        assert found.distance_by_class[kind][0] == exactly
        (when,) = found.sample_by_class[kind]
        assert (when < 0) == (found.pair_by_class[kind][0] is None)
        if when >= 0:
            assert single.distance_by_class[kind][when] == exactly
    assert found.distance[0] == min(found.distance_by_class[kind][0] for kind in PAIR_CLASSES)


def test_a_touch_of_a_single_sample_is_found(models):
    """Between the samples that are looked at first an arm is somewhere else for one sample."""
    robot, collision = models["panda_dual"]
    poses = {"cup_large": RigidTransform.from_components([-0.08, 0.45, 0], UP), "kitchen_sideboard": TABLE}
    poses["apple_juice"] = RigidTransform.from_components([0.10, 0.45, 0], UP)
    q = np.tile(robot.home, (1000, 1))
    assert swept_clearances(collision, q, poses).distance[0] > 0.0
    q[5 * STRIDE + 17, [5, 6]] = 0.0, -np.pi / 4  # the folded wrist, which touches the forearm
    report = swept_clearances(collision, q, poses)
    assert report.distance_by_class["self"][0] < 0.0
    assert report.sample_by_class["self"][0] == 5 * STRIDE + 17


@pytest.mark.parametrize("name", ROBOTS)
def test_no_point_moves_farther_than_its_levers_say(models, name):
    robot, collision = models[name]
    generator = np.random.default_rng(0)
    q = robot.clip(robot.home + generator.standard_normal((200, len(robot.home))))
    step = 1e-5 * generator.standard_normal(q.shape)
    before, turned_before = collision.shapes.poses(q, dict.fromkeys(OBJECTS, TABLE))
    after, turned_after = collision.shapes.poses(q + step, dict.fromkeys(OBJECTS, TABLE))
    radius = collision.shapes.model.geom_rbound[collision.shapes.geoms]
    turn = np.linalg.norm(turned_after - turned_before, axis=(2, 3)) / np.sqrt(2.0)
    moved = np.linalg.norm(after - before, axis=2) + turn * radius
    # Centre and farthest point do not move the same way: the sum is more than any point moves, the levers allow for it.
    allowed = np.abs(step) @ collision.shapes.levers().T
    assert (moved <= allowed * (1.0 + 1e-4) + 1e-12).all()


def test_bad_input(models):
    robot, collision = models["panda_dual"]
    q, poses, held, _ = random_motion(robot, 50, 0)
    with pytest.raises(ConfigurationError):
        swept_clearances(collision, q * np.nan, poses)
    with pytest.raises(UnknownNameError, match="apple_juice"):
        swept_clearances(collision, q, {name: pose for name, pose in poses.items() if name != "apple_juice"})
    with pytest.raises(UnknownNameError, match=r"'spoon'.*'cup_large'"):
        swept_clearances(collision, q, poses, {("spoon", "left"): np.ones(50, dtype=bool)})
    with pytest.raises(UnknownNameError, match=r"'spoon'.*'cup_large'"):
        swept_clearances(collision, q, poses, held, {("spoon", "left"): np.ones(50, dtype=bool)})
