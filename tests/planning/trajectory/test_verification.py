"""What a trajectory does to the objects; planted faults are found."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.planning.motion.allowed_contacts import collision_model
from sbam.planning.motion.carrying import hold_objects
from sbam.planning.motion.motion import with_approaches
from sbam.planning.plan import Plan
from sbam.planning.start import in_agent_frame
from sbam.planning.trajectory.timing import time_path
from sbam.planning.trajectory.verification import CLOSURE_POSITION, CLOSURE_ROTATION, phase_times, verify
from sbam.robots.inverse_kinematics import solve_poses
from sbam.scene import ObjectLibrary

RATE = 200.0


@pytest.fixture(scope="module")
def rehearsal(problem_of):
    """``rehearsal(plan)``: its motion, timed at 200 Hz."""

    def make(plan: Plan):
        poses = problem_of(plan).state(plan.solution.configurations).object_poses()
        times = plan.task.model.keypoint_times
        robot = in_agent_frame(plan.robot)
        holding = hold_objects(plan.task, robot, plan.grasps, times, plan.solution.configurations, poses)
        motion = with_approaches(plan.task, robot, collision_model(plan.task, robot), holding)
        return motion, *time_path(robot, motion.clock, motion.configurations, plan.settings.speed, RATE)

    return make


@pytest.fixture(scope="module")
def pouring(small_plan, rehearsal):
    return rehearsal(small_plan)


@pytest.fixture(scope="module")
def rolling(rolling_plan, rehearsal):
    return rehearsal(rolling_plan)


def failing(plan: Plan, rehearsed, **changes) -> set[str]:
    """Names of the checks that fail when something is changed."""
    motion, trajectory, clock = rehearsed
    arguments = {"task": plan.task, "grasps": plan.grasps, "trajectory": trajectory, "clearance": 0.0, **changes}
    robot = in_agent_frame(plan.robot)
    shapes = collision_model(arguments["task"], robot)
    _, checks = verify(robot=robot, collision=shapes, motion=motion, clock=clock, **arguments)
    return {check.name for check in checks if not check.ok}


def tcp_path(plan: Plan, hand, position: np.ndarray) -> RigidTransform:
    k = in_agent_frame(plan.robot).kinematics(position, [plan.robot.arms[hand].tcp_frame])
    return RigidTransform.from_components(k.position[:, 0], Rotation.from_matrix(k.rotation[:, 0]))


def test_good_plans_pass(small_plan, pouring, rolling_plan, rolling):
    assert failing(small_plan, pouring) == set()
    assert failing(rolling_plan, rolling) == set()


@pytest.mark.parametrize("which", ["pouring", "rolling"])
def test_objects_move_only_while_they_are_held(which, small_plan, rolling_plan):
    plan = small_plan if which == "pouring" else rolling_plan
    time = plan.trajectory.time
    for moved in plan.task.moved:
        pose = plan.T_agent_object[moved.name].as_matrix()
        phases = {p.name: p for p in plan.phases if p.role == moved.role and p.hand == moved.hands[0]}
        before, after = time <= phases["grasp"].end, time >= phases["place"].start
        np.testing.assert_allclose(
            pose[before], np.broadcast_to(moved.start.as_matrix(), pose[before].shape), atol=1e-9
        )
        np.testing.assert_allclose(
            pose[after], np.broadcast_to(moved.put_down.as_matrix(), pose[after].shape), atol=1e-9
        )
        assert before.any()
        assert after.any()
        way = np.linalg.norm(pose[:, :3, 3] - moved.start.translation, axis=1).max()
        assert way > 0.05
        # Nothing jumps, neither when it is taken nor when it is left.
        step = np.linalg.norm(np.diff(pose[:, :3, 3], axis=0), axis=1)
        assert step.max() < 2e-3


@pytest.mark.parametrize("which", ["pouring", "rolling"])
def test_every_hand_keeps_its_grasp_by_forward_kinematics(which, small_plan, rolling_plan):
    """From the closing to the opening of the fingers; for the pin both hands, so the loop stays closed."""
    plan = small_plan if which == "pouring" else rolling_plan
    for moved in plan.task.moved:
        for hand in moved.hands:
            phases = {p.name: p for p in plan.phases if p.role == moved.role and p.hand == hand}
            time = plan.trajectory.time
            held = np.flatnonzero((time >= phases["grasp"].start) & (time <= phases["place"].end))[::20]
            tcp = tcp_path(plan, hand, plan.trajectory.position[held])
            slip = (plan.T_agent_object[moved.name][held] * plan.grasps[moved.role, hand].T_object_tcp).inv() * tcp
            assert np.linalg.norm(slip.translation, axis=1).max() < CLOSURE_POSITION
            assert slip.rotation.magnitude().max() < CLOSURE_ROTATION


def test_both_hands_on_the_pin_move_as_one(rolling_plan):
    """The right hand in the left one's frame stands still within 1 mm and 0.5 degrees."""
    plan = rolling_plan
    (moved,) = plan.task.moved
    phase = next(p for p in plan.phases if p.name == "manipulate" and p.hand == "left")
    time = plan.trajectory.time
    held = np.flatnonzero((time >= phase.start) & (time <= phase.end))[::10]
    left, right = (tcp_path(plan, hand, plan.trajectory.position[held]) for hand in ("left", "right"))
    between = left.inv() * right
    wanted = plan.grasps[moved.role, "left"].T_object_tcp.inv() * plan.grasps[moved.role, "right"].T_object_tcp
    assert np.linalg.norm(between.translation - wanted.translation, axis=1).max() < 1e-3
    assert (between.rotation * wanted.rotation.inv()).magnitude().max() < np.deg2rad(0.5)


def test_a_hand_that_does_not_grasp_where_it_should(small_plan, pouring):
    for offset, kind in (
        (RigidTransform.from_translation([0.0, 0.003, 0.0]), "place"),
        (RigidTransform.from_rotation(Rotation.from_rotvec([0.0, 0.02, 0.0])), "angle"),
    ):
        key = ("pour_from", "right")
        grasp = small_plan.grasps[key]
        grasps = {**small_plan.grasps, key: replace(grasp, T_object_tcp=grasp.T_object_tcp * offset)}
        assert f"right hand keeps its {kind} on apple_juice" in failing(small_plan, pouring, grasps=grasps)


def test_a_second_hand_that_slips(rolling_plan, rolling):
    """The right wrist is 0.02 rad off for a while in the middle of the rolling."""
    _, trajectory, _ = rolling
    position = trajectory.position.copy()
    joint = rolling_plan.robot.arms["right"].joint_indices[-1]
    middle = slice(len(position) // 2, len(position) // 2 + 40)
    position[middle, joint] += 0.02
    found = failing(rolling_plan, rolling, trajectory=replace(trajectory, position=position))
    assert "right hand keeps its angle on rolling_pin" in found
    assert not any(name.startswith("left hand") for name in found)


def test_a_first_hand_that_leaves_the_path(small_plan, pouring):
    """The right shoulder is 0.01 rad off, some millimetres at the hand, for the whole pouring."""
    _, trajectory, clock = pouring
    moved = next(moved for moved in small_plan.task.moved if moved.role == "pour_from")
    position = trajectory.position.copy()
    position[(clock > moved.lift) & (clock < moved.place), small_plan.robot.arms["right"].joint_indices[0]] += 0.01
    found = failing(small_plan, pouring, trajectory=replace(trajectory, position=position))
    assert "apple_juice follows its path" in found
    assert "cup_large follows its path" not in found


def test_a_hand_that_moves_on_while_its_fingers_open(small_plan, pouring):
    _, trajectory, clock = pouring
    moved = next(moved for moved in small_plan.task.moved if moved.role == "pour_from")
    position = trajectory.position.copy()
    position[clock >= moved.place + 0.05, small_plan.robot.arms["right"].joint_indices[0]] += 0.01
    found = failing(small_plan, pouring, trajectory=replace(trajectory, position=position))
    assert "right hand keeps its place on apple_juice" in found


def with_obstacle(plan: Plan, at: np.ndarray, movable: bool):
    """The task with a small cup in its scene that takes no part."""
    model = replace(ObjectLibrary.built_in()["cup_small"], movable=movable)
    scene = replace(plan.task.scene, objects={**plan.task.scene.objects, "obstacle": model})
    poses = {**plan.task.T_agent_object, "obstacle": RigidTransform.from_translation(at)}
    return replace(plan.task, scene=scene, T_agent_object=poses)


def test_planted_obstacles(small_plan, pouring):
    """Where the right hand is in the middle of pouring; where the bottle is; far away."""
    _, trajectory, clock = pouring
    sample = int(np.argmin(np.abs(clock - 4.5)))
    hand = tcp_path(small_plan, "right", trajectory.position[[sample]]).translation[0]
    bottle = small_plan.T_agent_object["apple_juice"]
    in_plan = int(np.argmin(np.abs(small_plan.model_time - 4.5)))
    spout = bottle[in_plan].apply([0.0, 0.240, 0.0])
    assert "clearance arm-object" in failing(small_plan, pouring, task=with_obstacle(small_plan, hand, movable=True))
    assert "clearance arm-support" in failing(small_plan, pouring, task=with_obstacle(small_plan, hand, movable=False))
    assert "clearance object-object" in failing(
        small_plan, pouring, task=with_obstacle(small_plan, spout, movable=True)
    )
    away = np.array([0.0, 1.0, 0.0])
    assert failing(small_plan, pouring, task=with_obstacle(small_plan, away, movable=True)) == set()


def test_arms_that_meet(small_plan, pouring):
    """For a moment in the middle both hands are at the same place."""
    _, trajectory, _ = pouring
    position = trajectory.position.copy()
    robot = in_agent_frame(small_plan.robot)
    place = np.broadcast_to([0.0, 0.5, 0.4], (1, 2, 3))
    downwards = np.broadcast_to(np.diag([1.0, -1.0, -1.0]), (1, 2, 3, 3))
    meeting = solve_poses(robot, ("left", "right"), place, downwards, robot.home)
    assert meeting.reached().all()
    position[len(position) // 2 :][:8] = meeting.configurations
    assert "clearance arm-arm" in failing(small_plan, pouring, trajectory=replace(trajectory, position=position))


def test_a_demanded_clearance_that_is_not_kept(small_plan, pouring):
    found = failing(small_plan, pouring, clearance=0.09)
    assert {"clearance self", "clearance arm-support"} <= found


def test_too_heavy_objects(small_plan, pouring):
    moved = tuple(replace(m, model=replace(m.model, mass=15.0)) for m in small_plan.task.moved)
    assert failing(small_plan, pouring, task=replace(small_plan.task, moved=moved)) == {"torque limits"}


def test_torques_at_rest_are_those_of_pinocchio(small_plan, pouring):
    """The worst share of the limits, of a robot that stands at home with empty hands, by Pinocchio's gravity."""
    pin = pytest.importorskip("pinocchio")
    from sbam.robots import ROBOTS

    motion, trajectory, clock = pouring
    robot = in_agent_frame(small_plan.robot)
    count = len(trajectory.time)
    still = replace(
        trajectory,
        position=np.tile(robot.home, (count, 1)),
        velocity=np.zeros((count, 14)),
        acceleration=np.zeros((count, 14)),
    )
    light = tuple(replace(m, model=replace(m.model, mass=0.0)) for m in small_plan.task.moved)
    task = replace(small_plan.task, moved=light)
    shapes = collision_model(task, robot)
    _, checks = verify(task, robot, shapes, small_plan.grasps, motion, still, clock, 0.0)
    found = next(check for check in checks if check.name == "torque limits")
    model = pin.buildModelFromMJCF(str(ROBOTS["panda_dual"].parent / "panda_arm.xml"))
    data = model.createData()
    arm = robot.arms["left"].joint_indices
    gravity = pin.computeGeneralizedGravity(model, data, np.append(robot.home[arm], [0.04, 0.04]))[:7]
    assert found.worst == pytest.approx(float((np.abs(gravity) / robot.torque_limit[arm]).max()), rel=1e-3)


def test_phases_follow_each_other_on_the_trajectory(small_plan, pouring):
    motion, trajectory, clock = pouring
    phases = phase_times(motion, trajectory, clock)
    for hand in ("left", "right"):
        own = [phase for phase in phases if phase.hand == hand]
        assert [phase.name for phase in own] == ["approach", "grasp", "manipulate", "place", "retreat"]
        assert all(first.end == pytest.approx(second.start) for first, second in pairwise(own))
        assert 0.0 <= own[0].start < own[-1].end <= trajectory.duration
