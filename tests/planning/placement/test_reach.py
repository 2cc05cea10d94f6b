"""How well bases reach, against placing the robot there and against the arm's length."""

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.planning.placement.reach import hand_targets, reach_from
from sbam.planning.start import in_agent_frame
from sbam.robots.inverse_kinematics import solve_poses


@pytest.fixture(scope="module")
def case(small_plan):
    robot, task = in_agent_frame(small_plan.robot), small_plan.task
    poses = {
        moved.role: small_plan.T_agent_object[moved.name][
            np.searchsorted(small_plan.model_time, task.model.keypoint_times).clip(0, len(small_plan.model_time) - 1)
        ]
        for moved in task.moved
    }
    return robot, hand_targets(task, robot, poses)


def moved(robot, *moves: tuple[float, float, float]) -> RigidTransform:
    turn = Rotation.from_euler("z", np.array(moves)[:, 2:], degrees=True) * robot.T_world_base.rotation
    offset = np.column_stack([np.array(moves)[:, :2], np.zeros(len(moves))])
    return RigidTransform.from_components(robot.T_world_base.translation + offset, turn)


def test_where_a_plan_works_both_hands_reach(case):
    robot, targets = case
    reach = reach_from(robot, targets, moved(robot, (0, 0, 0)))
    assert (reach.miss == 0).all()
    assert (reach.share > 0).all()


def test_bases_are_independent_and_the_frame_is_of_no_account(case):
    robot, targets = case
    places = [(0, 0, 0), (0.1, -0.3, 0), (0, -0.6, 20)]
    together = reach_from(robot, targets, moved(robot, *places))
    for row, place in enumerate(places):
        alone = reach_from(robot.placed(moved(robot, (3, 4, 50))[0]), targets, moved(robot, place))
        np.testing.assert_allclose(alone.miss[0], together.miss[row], atol=1e-4)
        np.testing.assert_array_equal(alone.share[0], together.share[row])


def test_a_miss_is_at_least_what_the_arm_is_too_short(case):
    """The shoulder of a Panda stands still: no posture brings the hand nearer than the arm is long."""
    robot, targets = case
    far = moved(robot, (0, -1.0, 0))
    reach = reach_from(robot, targets, far)
    placed = robot.placed(far[0])
    for column, target in enumerate(targets):
        arm = robot.arms[target.hand]
        shoulder = placed.kinematics(placed.home[None], [arm.shoulder_frame]).position[0, 0]
        distance = np.linalg.norm(target.position - shoulder, axis=-1) - arm.length
        assert reach.miss[0, column] >= distance.max(axis=1).min() - 0.005
        assert reach.miss[0, column] < distance.max() + 0.25 * np.pi
    assert (reach.share == 0).all()


def test_grasps_that_reach_are_solved_where_the_robot_stands(case):
    """With the robot placed there, inverse kinematics of its own reaches with about as many grasps or more."""
    robot, targets = case
    place = moved(robot, (0.1, -0.1, 15))
    reach = reach_from(robot, targets, place)
    standing = robot.placed(place[0])
    for column, target in enumerate(targets):
        ends = target.position[:, 0], target.rotation[:, 0]
        starts = np.concatenate([standing.home[None], np.tile(standing.home, (4, 1)) + 0.3 * np.eye(4, 14)])
        solved = np.zeros(len(target.position), dtype=bool)
        for start in starts:
            solution = solve_poses(standing, [target.hand], ends[0][:, None], ends[1][:, None], standing.clip(start))
            solved |= solution.reached(2e-3, 0.01)
        assert solved.mean() >= reach.share[0, column] - 1e-9
