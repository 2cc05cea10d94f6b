"""Choose the grasps with which the whole action can be done, in pairs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from sbam.demonstrations.demonstration import Hand
from sbam.errors import UnreachableError
from sbam.planning.grasps import Grasp, candidate_grasps
from sbam.planning.inverse_kinematics import solve_poses
from sbam.planning.task import MovedObject, Task
from sbam.robots import Robot

Array = NDArray[np.float64]

RANDOM_NEAR_HOME = 3  # starts home + N(0, 0.5)
RANDOM_STARTS = 4  # starts anywhere within the limits
LIMIT_MARGIN = 0.05  # rad: postures nearer to a limit rank lower
KEEP = 12  # best grasps of each hand that are combined


@dataclass(frozen=True)
class FollowedGrasp:
    """A grasp with which one arm can follow its object through all checkpoints.

    Attributes:
        grasp: the grasp.
        configurations: (M, n) at the checkpoints; only the arm's joints count.
        score: lower is better.
    """

    grasp: Grasp
    configurations: Array
    score: float


def follow_grasps(
    robot: Robot, moved: MovedObject, hand: Hand, poses: RigidTransform, seed: int = 0
) -> list[FollowedGrasp]:
    """All candidate grasps of one hand that work at every checkpoint, best first.

    Inverse kinematics is started from eight postures at the hardest checkpoint, the one of largest tilt, and goes
    outwards both ways from what is found there.

    Args:
        robot: robot standing in the agent frame.
        moved: the object.
        hand: the hand.
        poses: M poses of the object at the checkpoints, agent frame, in order of time.
        seed: of the random starts.

    Raises:
        UnreachableError: if none works; says which checkpoint and how near the best came.
    """
    grasps = candidate_grasps(robot, moved, hand)
    joints = np.flatnonzero(robot.frame_joints(robot.arms[hand].tcp_frame))
    checkpoints, count = len(poses), len(grasps)
    tcp = [poses * grasp.T_object_tcp for grasp in grasps]
    position = np.array([t.translation for t in tcp])  # (G, M, 3)
    rotation = np.array([t.rotation.as_matrix() for t in tcp])  # (G, M, 3, 3)
    hardest = int(np.argmax((poses.rotation * moved.start.rotation.inv()).magnitude()))

    starts = _starts(robot, hand, seed)
    solution = solve_poses(
        robot,
        [hand],
        np.repeat(position[:, [hardest]], len(starts), axis=0),
        np.repeat(rotation[:, [hardest]], len(starts), axis=0),
        np.tile(starts, (count, 1)),
        pull=(3e-2, 1e-3),
    )
    reached = solution.reached().reshape(count, len(starts))
    q = solution.configurations.reshape(count, len(starts), -1)
    rank = np.where(reached, _limit_cost(robot, q, joints) + 0.1 * np.abs(q - robot.home)[..., joints].max(-1), np.inf)
    works = reached.any(axis=1)
    path = np.empty((count, checkpoints, q.shape[-1]))
    path[:, hardest] = q[np.arange(count), rank.argmin(axis=1)]
    failed_at = np.where(works, -1, hardest)
    for order in (range(hardest + 1, checkpoints), range(hardest - 1, -1, -1)):
        for m in order:
            alive = np.flatnonzero(works)
            if len(alive) == 0:
                break
            before = path[alive, m - order.step]
            step = solve_poses(
                robot, [hand], position[alive, m, None], rotation[alive, m, None], before, pull=(3e-2, 1e-3)
            )
            path[alive, m] = step.configurations
            jump = np.abs(step.configurations - before)[:, joints].max(axis=1)
            good = step.reached() & (jump < 1.5)
            failed_at[alive[~good]] = m
            works[alive[~good]] = False
    if not works.any():
        nearest = 1e3 * float(solution.position_error.min())
        where = np.bincount(failed_at, minlength=checkpoints)
        raise UnreachableError(
            f"{robot.name}'s {hand} hand can hold {moved.name!r} with none of {count} grasps through the whole action; "
            f"{where[hardest]} fail already where it is tilted most (the nearest by {nearest:.0f} mm); "
            "move the robot or the objects"
        )
    return sorted(
        (FollowedGrasp(grasps[g], path[g], _score(robot, grasps[g], path[g], joints)) for g in np.flatnonzero(works)),
        key=lambda followed: followed.score,
    )


def _starts(robot: Robot, hand: Hand, seed: int) -> Array:
    """Eight postures and the description's seeds, (S, n)."""
    generator = np.random.default_rng(seed)
    home = robot.clip(robot.home)
    lower = np.where(np.isfinite(robot.lower), robot.lower, -np.pi)
    upper = np.where(np.isfinite(robot.upper), robot.upper, np.pi)
    near = robot.clip(home + 0.5 * generator.standard_normal((RANDOM_NEAR_HOME, len(home))))
    anywhere = generator.uniform(lower, upper, (RANDOM_STARTS, len(home)))
    arm = robot.arms[hand]
    seeds = np.tile(home, (len(arm.ik_seeds), 1))
    seeds[:, arm.joint_indices] = arm.ik_seeds
    return np.concatenate([home[None], seeds, near, anywhere])


def _limit_cost(robot: Robot, q: Array, joints: NDArray[np.int_]) -> Array:
    """How much postures press against the joint limits, (...,)."""
    room = np.minimum(q - robot.lower, robot.upper - q)[..., joints].min(axis=-1)
    return np.maximum(0.0, 1.0 - room / LIMIT_MARGIN)


def _score(robot: Robot, grasp: Grasp, path: Array, joints: NDArray[np.int_]) -> float:
    jump = float(np.abs(np.diff(path, axis=0))[:, joints].max(initial=0.0))
    travel = float(np.abs(np.diff(path, axis=0))[:, joints].sum(axis=1).mean()) if len(path) > 1 else 0.0
    limits = float(_limit_cost(robot, path, joints).max())
    return jump + 0.5 * travel + limits + 0.5 * grasp.human_distance


def choose_grasps(
    task: Task, robot: Robot, poses: Mapping[str, RigidTransform], checker: object | None, seed: int = 0
) -> Iterator[dict[tuple[str, Hand], FollowedGrasp]]:
    """Combinations of grasps, best first; each is consistent with the others at all checkpoints.

    Args:
        task: model bound to a scene.
        robot: robot standing in the agent frame.
        poses: role -> M poses at the checkpoints, agent frame.
        checker: judges clearances of combinations, or None.
        seed: of the random starts.

    Yields:
        (role, hand) -> grasp.
    """
    keys = [(moved, hand) for moved in task.moved for hand in moved.hands]
    options = [follow_grasps(robot, moved, hand, poses[moved.role], seed)[:KEEP] for moved, hand in keys]
    ranked = sorted(product(*options), key=lambda combination: sum(item.score for item in combination))
    for combination in ranked:
        yield {(moved.role, hand): item for (moved, hand), item in zip(keys, combination, strict=True)}
