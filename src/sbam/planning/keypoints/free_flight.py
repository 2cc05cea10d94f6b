"""Where the objects would go if no robot had to hold them.

The same problem is solved with hands that fly (six degrees of freedom each and no limits). The result says what the
action wants, apart from what a robot can do: grasps are chosen along it, and the robot's solution starts from it.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
from scipy.spatial.transform import RigidTransform

import sbam.robots
from sbam.planning.keypoints.objective import build_problem
from sbam.planning.keypoints.solvers.result import Solution
from sbam.planning.keypoints.solvers.sequential import solve_sequentially
from sbam.planning.keypoints.solvers.whole_trajectory import solve_whole_trajectory
from sbam.planning.settings import PlanSettings
from sbam.planning.task import Task
from sbam.robots import Robot, load_robot


@cache
def flying_hands() -> Robot:
    """Two hands without arms."""
    return load_robot(Path(sbam.robots.__file__).parent / "models" / "flying_hands.yaml")


def solve_free_flight(task: Task, settings: PlanSettings) -> tuple[Solution, dict[str, RigidTransform]]:
    """Optimise the poses of the moved objects themselves.

    Each object hangs on one flying hand whose frame coincides with the object's at its start. An object that two hands
    hold needs but one.

    Args:
        task: model bound to a scene.
        settings: weights of the terms.

    Returns:
        The solution, and role -> K poses at the keypoints, agent frame.
    """
    robot = flying_hands()
    single_handed = replace(task, moved=tuple(replace(moved, hands=moved.hands[:1]) for moved in task.moved))
    grasps, start = {}, np.zeros(len(robot.joint_names))
    for moved in single_handed.moved:
        hand = moved.hands[0]
        grasps[moved.role, hand] = RigidTransform.from_rotation(moved.start.rotation.inv())
        start[robot.arms[hand].joint_indices[:3]] = moved.start.translation
    problem = build_problem(single_handed, robot, grasps, settings, free_flight=True)
    if settings.solver == "sequential":
        solution = solve_sequentially(problem, start)
    else:
        solution = solve_whole_trajectory(problem, [start])
    return solution, problem.state(solution.configurations).object_poses()
