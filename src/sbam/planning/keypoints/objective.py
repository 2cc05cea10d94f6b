"""Build the optimisation problem of a task for a robot that holds its objects."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from sbam.constraints import RegionReference, constraint_type
from sbam.demonstrations.demonstration import Hand
from sbam.planning.keypoints.problem import Problem
from sbam.planning.keypoints.state import Carrying, RegionPoint, Workspace
from sbam.planning.keypoints.targets import compared_changes, pair_target, vector_shift
from sbam.planning.keypoints.terms import (
    Closure,
    Damping,
    HumanLikeness,
    NaturalJoints,
    Resting,
    Similarity,
    Smoothness,
    Term,
)
from sbam.planning.keypoints.weights import pair_weights
from sbam.planning.settings import PlanSettings
from sbam.planning.task import Task
from sbam.robots import HumanLikeness as HumanLikenessPosture
from sbam.robots import Robot
from sbam.robots.natural_joints import NaturalJoints as NaturalJointsPosture

Array = NDArray[np.float64]

DEFAULT_HUMAN_LIKENESS = 3.0  # lambda_h of robots whose arms are like a person's


def human_likeness_weight(robot: Robot, settings: PlanSettings) -> float:
    """lambda_h for a robot: as set, else the default for robots whose arms are like a person's and 0 for others."""
    if settings.human_likeness is not None:
        return settings.human_likeness
    return DEFAULT_HUMAN_LIKENESS if robot.description.human_likeness else 0.0


def build_problem(
    task: Task,
    robot: Robot,
    T_object_tcp: Mapping[tuple[str, Hand], RigidTransform],
    settings: PlanSettings,
    times: Array | None = None,
) -> Problem:
    """The problem of bringing a task's objects through its keypoints.

    Args:
        task: model bound to a scene.
        robot: a robot standing in the agent frame.
        T_object_tcp: (role, hand) -> grasp.
        settings: weights of the terms.
        times: (K,) keypoints on the model's time axis, s; default the model's own.

    Returns:
        The problem; its workspace's carryings are in the order of ``task.moved``.
    """
    times = task.model.keypoint_times if times is None else times
    carryings = [
        Carrying(moved.role, moved.hands[0], T_object_tcp[moved.role, moved.hands[0]].inv()) for moved in task.moved
    ]
    references = sorted(
        {reference for c in task.model.changes for reference in (c.pair.first, c.pair.second) if reference is not None}
    )
    roles = [carrying.role for carrying in carryings]
    points = [
        RegionPoint(roles.index(reference.role), task.region_center(reference))
        if reference.role in roles
        else RegionPoint(-1, task.region_at_start(reference))
        for reference in references
    ]
    weight = human_likeness_weight(robot, settings)
    posture = (
        (NaturalJointsPosture if settings.posture == "joints" else HumanLikenessPosture)(robot) if weight else None
    )
    workspace = Workspace(robot, carryings, points, posture.frames if posture else ())
    terms: list[Term] = [*_similarities(task, references, times, settings), _damping(task, times, settings)]
    if isinstance(posture, NaturalJointsPosture):
        terms.append(NaturalJoints(weight, posture, tuple(robot.arms)))
    elif posture:
        terms.append(HumanLikeness(weight, posture))
    if task.model.mode == "default":
        terms.append(_resting(task, times))
        terms.append(Smoothness(settings.smoothness))
    for index, moved in enumerate(task.moved):
        for hand in moved.hands[1:]:
            grasp = T_object_tcp[moved.role, hand]
            arm = workspace.arms.index(hand)
            terms.append(Closure(index, arm, grasp.translation, grasp.rotation.as_matrix()))
    return Problem(workspace, tuple(terms), len(times))


def _similarities(
    task: Task, references: Sequence[RegionReference], times: Array, settings: PlanSettings
) -> list[Similarity]:
    """One similarity term per constraint type that occurs in the model."""
    index = {reference: i for i, reference in enumerate(references)}
    terms = []
    for name in sorted({change.constraint for change in task.model.changes}):
        changes = [change for change in compared_changes(task, settings) if change.constraint == name]
        constraint = constraint_type(name).in_mode(task.model.mode)
        target = np.stack([pair_target(task, change, times, settings) for change in changes], axis=1)
        weight = np.stack([pair_weights(task.model, c, times, settings.proximity) for c in changes], axis=1)
        terms.append(
            Similarity(
                constraint=constraint,
                pairs=tuple(str(change.pair) for change in changes),
                first=np.array([index[change.pair.first] for change in changes]),
                second=np.array([-1 if c.pair.second is None else index[c.pair.second] for c in changes]),
                origin=np.array([task.region_at_start(change.pair.first) for change in changes]),
                shift=np.array([vector_shift(task, change) for change in changes]),
                target=target,
                weight=weight,
            )
        )
    return terms


def _damping(task: Task, times: Array, settings: PlanSettings) -> Damping:
    """t_d: constant in mode ``default``; in mode ``paper`` w'_o = c dt std, with the mean standard deviation."""
    roles = tuple(moved.role for moved in task.moved)
    start = np.array([moved.start.translation for moved in task.moved]).reshape(-1, 3)
    if task.model.mode == "default":
        return Damping(roles, np.full((len(times), len(roles)), settings.damping), start)
    coefficient = constraint_type(task.model.constraint).paper_damping
    step = np.diff(times, prepend=times[0])
    weight = np.zeros((len(times), len(roles)))
    for i, role in enumerate(roles):
        stds = []
        for change in task.model.changes:
            if role in change.pair.roles:
                scale = np.array([1000.0 if channel.unit == "m" else 1.0 for channel in change.channels])
                stds.append((change.at(times)[1] * scale).mean(axis=1))
        weight[:, i] = 1000.0 * coefficient * step * np.mean(stds, axis=0)
    return Damping(roles, weight, start)


def _resting(task: Task, times: Array) -> Resting:
    """Objects stand still before their lift and after they are put down."""
    tolerance = 1e-9
    before = np.array([times <= moved.lift + tolerance for moved in task.moved]).T
    after = np.array([times >= moved.place - tolerance for moved in task.moved]).T
    start_position = np.array([moved.start.translation for moved in task.moved])
    end_position = np.array([moved.put_down.translation for moved in task.moved])
    start_rotation = np.array([moved.start.rotation.as_matrix() for moved in task.moved])
    end_rotation = np.array([moved.put_down.rotation.as_matrix() for moved in task.moved])
    return Resting(
        objects=tuple(moved.role for moved in task.moved),
        resting=before | after,
        position=np.where(before[..., None], start_position, end_position),
        rotation=np.where(before[..., None, None], start_rotation, end_rotation),
    )
