"""Clearances: against all pairs measured one by one, and against hand-made situations."""

from itertools import product

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.errors import ConfigurationError, UnknownNameError
from sbam.robots import PAIR_CLASSES, CollisionModel, load_robot, point_jacobian
from sbam.scene import ObjectLibrary

UP = Rotation.from_euler("x", 90, degrees=True)
LIBRARY = ObjectLibrary.built_in()
OBJECTS = {name: LIBRARY[name] for name in ("cup_large", "apple_juice", "kitchen_sideboard")}
POSES = {
    "cup_large": RigidTransform.from_components([-0.08, 0.45, 0], UP),
    "apple_juice": RigidTransform.from_components([0.10, 0.45, 0], UP),
    "kitchen_sideboard": RigidTransform.from_components([0, 0.54, -0.024], Rotation.from_euler("x", 180, degrees=True)),
}
DISTANCE_MAX = 0.1


@pytest.fixture(scope="module")
def robot():
    return load_robot("panda_dual")


@pytest.fixture(scope="module")
def collisions(robot):
    return CollisionModel(robot, OBJECTS)


def around_home(robot, count, spread=0.5, seed=0):
    return robot.clip(robot.home + np.random.default_rng(seed).normal(size=(count, len(robot.home))) * spread)


def brute_force(collisions, configuration, poses):
    """Smallest distance of each pair of owners: every pair of shapes, posed by MuJoCo itself."""
    model = collisions.shapes.model
    data = mujoco.MjData(model)
    data.qpos[:] = configuration
    for name, pose in poses.items():
        mocap = model.body_mocapid[model.body(f"object/{name}").id]
        data.mocap_pos[mocap] = pose.translation
        data.mocap_quat[mocap] = pose.rotation.as_quat(scalar_first=True)
    mujoco.mj_kinematics(model, data)
    names = [model.body(model.geom_bodyid[g]).name.removeprefix("object/") for g in range(model.ngeom)]
    distances = {}
    for a, b in product(range(model.ngeom), repeat=2):
        if a < b and names[a] != names[b]:
            key = frozenset((names[a], names[b]))
            distance = mujoco.mj_geomDistance(model, data, a, b, DISTANCE_MAX, None)
            distances[key] = min(distance, distances.get(key, DISTANCE_MAX))
    return distances


def side(name):
    return next((s for s in ("left", "right") if name.startswith(s)), name)


def test_against_every_pair_of_shapes(robot, collisions):
    q = around_home(robot, 60, spread=1.0)
    report = collisions.clearances(q, POSES, distance_max=DISTANCE_MAX)
    near_count = 0
    for sample, configuration in enumerate(q):
        distances = brute_force(collisions, configuration, POSES)
        arm_arm = [d for pair, d in distances.items() if {side(n) for n in pair} == {"left", "right"}]
        support = [
            distance
            for pair, distance in distances.items()
            if "kitchen_sideboard" in pair and not pair & {"left_link0", "right_link0", "cup_large", "apple_juice"}
        ]
        with_object = [
            distance
            for pair, distance in distances.items()
            if len(pair & {"cup_large", "apple_juice"}) == 1
            and not pair & {"kitchen_sideboard", "left_link0", "right_link0"}
        ]
        for name, expected in (("arm-arm", arm_arm), ("arm-support", support), ("arm-object", with_object)):
            found = report.distance_by_class[name][sample]
            assert found == pytest.approx(min(expected), abs=1e-9)
            pair = report.pair_by_class[name][sample]
            assert (pair is None) == (found == DISTANCE_MAX)
            near_count += pair is not None
        assert report.distance[sample] == min(report.distance_by_class[name][sample] for name in PAIR_CLASSES)
    assert near_count > 10


def test_many_samples_equal_single_samples(robot, collisions):
    q = around_home(robot, 30, seed=1)
    turns = Rotation.from_rotvec(np.linspace([0, 0, 0], [0, 0, 60], 30), degrees=True) * UP
    path = RigidTransform.from_components(np.linspace([-0.3, 0.3, 0.1], [0.1, 0.5, 0.4], 30), turns)
    together = collisions.clearances(q, {**POSES, "cup_large": path})
    for sample in range(30):
        alone = collisions.clearances(q[sample : sample + 1], {**POSES, "cup_large": path[sample]})
        assert alone.distance[0] == pytest.approx(together.distance[sample], abs=1e-9)
        assert alone.pair[0] == together.pair[sample]


@pytest.mark.parametrize("seed", range(3))
def test_motions_equal_the_worst_of_their_samples(robot, collisions, seed):
    motions, length = 3, 20
    ends = around_home(robot, 2 * motions, spread=0.8, seed=seed).reshape(2, motions, 1, -1)
    share = np.linspace(0.0, 1.0, length)[:, None]
    q = ((1 - share) * ends[0] + share * ends[1]).reshape(motions * length, -1)
    held = {("cup_large", "left"): np.arange(len(q)) % length > length // 2}
    single = collisions.clearances(q, POSES, held, distance_max=DISTANCE_MAX)
    whole = collisions.clearances(q, POSES, held, distance_max=DISTANCE_MAX, motions=motions)
    assert whole.distance.shape == (motions,)
    for name in PAIR_CLASSES:
        each = single.distance_by_class[name].reshape(motions, length)
        np.testing.assert_allclose(whole.distance_by_class[name], each.min(axis=1), atol=1e-9)
        for motion, when in enumerate(whole.sample_by_class[name]):
            assert (when < 0) == (whole.pair_by_class[name][motion] is None)
            if when >= 0:
                assert when // length == motion
                assert single.distance_by_class[name][when] == pytest.approx(each[motion].min(), abs=1e-9)


@pytest.mark.parametrize("classes", [("arm-arm",), ("palm-object", "self"), ("arm-object",)])
def test_only_the_classes_that_are_asked_for(robot, collisions, classes):
    q = around_home(robot, 40, spread=0.8, seed=5)
    held = {("cup_large", "left"): np.arange(len(q)) % 2 == 0}
    everything = collisions.clearances(q, grasp_of_cup(robot), held)
    some = collisions.clearances(q, grasp_of_cup(robot), held, classes=classes)
    for name in PAIR_CLASSES:
        expected = everything.distance_by_class[name] if name in classes else DISTANCE_MAX
        np.testing.assert_allclose(some.distance_by_class[name], expected, atol=1e-6)
    assert any((everything.distance_by_class[name] < DISTANCE_MAX).any() for name in classes)


def test_home_is_free_and_its_base_may_stand_on_the_table(robot, collisions):
    report = collisions.clearances(robot.home[None], POSES)
    assert report.worst[2] > 0.03
    assert report.pair_by_class["arm-support"] == (None,)


def test_stored_postures_do_not_touch_themselves(robot, collisions):
    seeds = robot.home.copy()
    for arm in robot.arms.values():
        seeds[arm.joint_indices] = arm.ik_seeds[0]
    report = collisions.clearances(np.array([robot.home, seeds]), POSES)
    assert (report.distance > 0.02).all()


def test_folded_wrist_touches_the_forearm(robot, collisions):
    """With joint 6 near its lower limit the hand lies beside the forearm, turned so that the palm meets it."""
    folded = robot.home.copy()
    folded[[5, 6]] = 0.0, -np.pi / 4
    report = collisions.clearances(folded[None], POSES)
    assert report.distance_by_class["self"][0] < 0
    assert set(report.pair_by_class["self"][0]) == {"left_link5", "left_hand"}


def grasp_of_cup(robot):
    """A cup in the left hand at home, and the juice in the way of the right hand."""
    kinematics = robot.kinematics(robot.home[None], ["left_tcp", "right_tcp"])
    return {
        **POSES,
        "cup_large": RigidTransform.from_components(kinematics.position[0, 0] - [0, 0, 0.115], UP),
        "apple_juice": RigidTransform.from_components(kinematics.position[0, 1] - [0, 0, 0.225], UP),
    }


def test_holding_fingers_may_touch_what_they_hold(robot, collisions):
    poses = grasp_of_cup(robot)
    q = np.tile(robot.home, (2, 1))
    free = collisions.clearances(q, poses)
    assert set(free.pair_by_class["arm-object"][0]) & {"cup_large", "apple_juice"}
    held = {("cup_large", "left"): np.array([False, True]), ("apple_juice", "right"): np.array([False, True])}
    report = collisions.clearances(q, poses, held)
    assert report.distance_by_class["arm-object"][0] < 0 < report.distance_by_class["arm-object"][1]
    in_the_palm = {**poses, "cup_large": RigidTransform.from_translation([0, 0, 0.06]) * poses["cup_large"]}
    assert collisions.clearances(q, in_the_palm, held).distance_by_class["palm-object"][1] < 0
    wrong_hand = {("cup_large", "right"): np.array([True, True])}
    assert (collisions.clearances(q, poses, wrong_hand).distance_by_class["arm-object"] < 0).all()


def test_objects_count_against_each_other_while_one_is_held(robot, collisions):
    poses = {**POSES, "apple_juice": RigidTransform.from_components([0.01, 0.45, 0], UP)}
    q = np.tile(robot.home, (2, 1))
    report = collisions.clearances(q, poses, {("cup_large", "left"): np.array([False, True])})
    distances = report.distance_by_class["object-object"]
    assert distances[0] == DISTANCE_MAX
    # the cup's wide upper part (radius 42 mm) against the bottle's face 36 mm from its axis, 90 mm apart
    assert distances[1] == pytest.approx(0.09 - 0.042 - 0.036, abs=1e-5)
    assert set(report.pair_by_class["object-object"][1]) == {"cup_large", "apple_juice"}


def test_allowed_contacts(robot):
    allowed = CollisionModel(robot, OBJECTS, allowed=[("cup_large", name) for name in robot.frame_names[1:12]])
    report = allowed.clearances(robot.home[None], grasp_of_cup(robot))
    pair = report.pair_by_class["arm-object"][0]
    assert pair is not None and "cup_large" not in pair
    with pytest.raises(UnknownNameError, match="saucer"):
        CollisionModel(robot, OBJECTS, allowed=[("cup_large", "saucer")])


def test_slope_of_the_distance(robot, collisions):
    """The normal and the nearest points give the derivative of the distance with respect to the joints."""
    margin, step = 0.05, 1e-6
    q = around_home(robot, 200, seed=3)
    near = collisions.near(q, POSES, margin=margin)
    assert len(near.sample) > 100 and (near.distance < margin).all()
    smooth = np.flatnonzero((near.distance > 1e-3) & (near.pair_class == PAIR_CLASSES.index("arm-arm")))
    assert len(smooth) > 3
    for i in smooth[:20]:
        at = q[near.sample[i]]
        kinematics = robot.kinematics(at[None], [])
        points = (near.point_first[i : i + 1], near.point_second[i : i + 1])
        first, second = (
            point_jacobian(kinematics, point, robot.frame_joints(name))[0]
            for point, name in zip(points, (near.first[i], near.second[i]), strict=True)
        )
        slope = near.normal[i] @ (first - second)
        for joint in range(len(at)):
            ends = []
            for sign in (-1, 1):
                other = collisions.near((at + sign * step * np.eye(14)[joint])[None], POSES, margin=margin + 0.01)
                same = [
                    distance
                    for a, b, distance in zip(other.first, other.second, other.distance, strict=True)
                    if (a, b) == (near.first[i], near.second[i]) and abs(distance - near.distance[i]) < 1e-4
                ]
                ends.append(min(same, key=lambda distance: abs(distance - near.distance[i])))
            assert (ends[1] - ends[0]) / (2 * step) == pytest.approx(slope[joint], abs=1e-4)


def test_lower_bounds_never_exceed_the_distance(robot, collisions):
    q = around_home(robot, 20, spread=1.0, seed=4)
    position, rotation = collisions.shapes.poses(q, POSES)
    model = collisions.shapes.model
    pairs = np.array([(a, b) for a in range(model.ngeom) for b in range(a)])
    sample, pair, bound = collisions.shapes.near(position, rotation, pairs, 0.2)
    data = mujoco.MjData(model)
    seen = set(zip(sample.tolist(), pair.tolist(), strict=True))
    for s in range(len(q)):
        data.geom_xpos[:], data.geom_xmat[:] = position[s], rotation[s].reshape(-1, 9)
        exact = [mujoco.mj_geomDistance(model, data, a, b, 0.2, None) for a, b in pairs.tolist()]
        for p, distance in enumerate(exact):
            assert distance >= 0.2 or (s, p) in seen
        here = sample == s
        assert (bound[here] <= np.array(exact)[pair[here]] + 1e-6).all()


def test_torso_counts_as_moving(torso_robot):
    """What a lift moves is compared with furniture; the platform, which stands, is not."""
    collisions = CollisionModel(torso_robot, {"kitchen_sideboard": LIBRARY["kitchen_sideboard"]})
    table = RigidTransform.from_components([0, -0.5, -1.0], Rotation.identity())
    report = collisions.clearances(torso_robot.home[None], {"kitchen_sideboard": table})
    assert report.pair_by_class["arm-support"] == (None,)
    table = RigidTransform.from_components([0, -0.5, -0.2], Rotation.identity())
    report = collisions.clearances(torso_robot.home[None], {"kitchen_sideboard": table})
    assert report.pair_by_class["arm-support"][0] is not None
    assert "platform" not in report.pair_by_class["arm-support"][0]


def test_bad_input(robot, collisions):
    q = robot.home[None]
    with pytest.raises(UnknownNameError, match="apple_juice"):
        collisions.clearances(q, {"cup_large": POSES["cup_large"]})
    with pytest.raises(UnknownNameError, match=r"'spoon'.*'cup_large'"):
        collisions.clearances(q, POSES, {("spoon", "left"): np.array([True])})
    with pytest.raises(UnknownNameError, match="third"):
        collisions.clearances(q, POSES, {("cup_large", "third"): np.array([True])})
    with pytest.raises(ConfigurationError):
        collisions.clearances(q * np.nan, POSES)
    empty = collisions.clearances(np.empty((0, 14)), POSES)
    assert empty.distance.shape == (0,) and empty.pair == ()
