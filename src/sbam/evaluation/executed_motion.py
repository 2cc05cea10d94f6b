"""What an execution does to the objects, by a robot or by hands that fly."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.planning.keypoints.free_flight import solve_free_flight
from sbam.planning.motion.object_path import object_path, shapes_of
from sbam.planning.plan import Plan
from sbam.planning.settings import PlanSettings
from sbam.planning.task import RoleHand, Task
from sbam.planning.trajectory.trajectory import JointTrajectory
from sbam.robots import NaturalDirections

FLIGHT_STEP = 0.01  # s between the samples of a flight


@dataclass(frozen=True)
class ExecutedMotion:
    """An execution, as far as it can be compared with a person.

    Attributes:
        task: the model bound to the scene.
        keypoint_poses: role -> optimised poses of every moved object at the model's keypoints, agent frame.
        time: from the first sample, s.
        model_time: time on the model's axis of every sample, s.
        T_agent_object: object name -> poses of every moved object, agent frame.
        objective: exact objective of the optimised keypoints.
        human_deviation: mean angle between the arms and a person's natural posture at the keypoints, degrees; None
            without arms.
        trajectory: of the joints; None without arms.
        problems: what is wrong with it, a sentence each.
    """

    task: Task
    keypoint_poses: Mapping[str, RigidTransform]
    time: Float[np.ndarray, " samples"]
    model_time: Float[np.ndarray, " samples"]
    T_agent_object: Mapping[str, RigidTransform]
    objective: float
    human_deviation: float | None
    trajectory: JointTrajectory | None
    problems: tuple[str, ...]


def executed_plan(plan: Plan) -> ExecutedMotion:
    """The execution that a robot's plan is."""
    robot, task = plan.robot, plan.task
    frames = [robot.arms[moved.hands[0]].tcp_frame for moved in task.moved]
    kinematics = robot.kinematics(plan.solution.configurations, frames)
    T_agent_world, poses = plan.T_world_agent.inv(), {}
    for index, moved in enumerate(task.moved):
        rotation = Rotation.from_matrix(kinematics.rotation[:, index])
        T_agent_tcp = T_agent_world * RigidTransform.from_components(kinematics.position[:, index], rotation)
        poses[moved.role] = T_agent_tcp * plan.grasps[RoleHand(moved.role, moved.hands[0])].T_object_tcp.inv()
    posture = NaturalDirections(robot)
    deviation = posture.deviation(robot.kinematics(plan.solution.configurations, posture.frames))
    return ExecutedMotion(
        task=task,
        keypoint_poses=poses,
        time=plan.time,
        model_time=plan.model_time,
        T_agent_object=plan.T_agent_object,
        objective=plan.solution.objective,
        human_deviation=float(deviation.mean()),
        trajectory=plan.trajectory,
        problems=plan.problems,
    )


def flight(task: Task, settings: PlanSettings) -> ExecutedMotion:
    """The execution by hands without arms: what the action wants, whatever a robot can do."""
    solution, poses = solve_free_flight(task, settings)
    times = task.model.keypoint_times
    model_time = np.linspace(0.0, times[-1], round(times[-1] / FLIGHT_STEP) + 1)
    shapes = shapes_of(task) if settings.between == "primitive" else {}
    paths = {
        moved.name: object_path(task, moved, times, poses[moved.role], model_time, shapes.get(moved.role)).pose
        for moved in task.moved
    }
    return ExecutedMotion(task, poses, model_time, model_time, paths, solution.objective, None, None, ())
