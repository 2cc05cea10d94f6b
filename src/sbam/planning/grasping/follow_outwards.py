"""Follow the poses of a hand from the hardest one outwards, both ways in time.

Where one pose is solved, its neighbours are solved from there: the arm keeps its branch, and what is hard comes first.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from sbam.robots import Robot
from sbam.robots.description import ArmName
from sbam.robots.inverse_kinematics import ROTATION_LENGTH, PoseSolution, solve_poses

PULL = (3e-2, 1e-3)  # m: how strongly poses are solved near their start, one stage each
LARGEST_JUMP = 1.5  # rad (or m) of any joint from one pose to the next; more is another branch
MOST_AT_ONCE = 4000  # targets solved in one batch; more do not fit into caches


@dataclass(frozen=True)
class OutwardPaths:
    """Paths of one hand over moments.

    Attributes:
        configurations: rad or m; NaN where a path was given up.
        miss: how far the hand stays away, m; a radian of orientation counts 0.25 m; inf where it was given up.
        broken_at: the moment at which a path breaks: a pose out of reach or in another branch; -1 where none is.
    """

    configurations: Float[np.ndarray, "paths moments joints"]
    miss: Float[np.ndarray, "paths moments"]
    broken_at: Int[np.ndarray, " paths"]


def follow_outwards(
    robot: Robot,
    hand: ArmName,
    position: Float[np.ndarray, "paths moments 3"],
    rotation: Float[np.ndarray, "paths moments 3 3"],
    first: Float[np.ndarray, "paths joints"],
    hardest: int,
    *,
    give_up: bool = True,
    iterations: int = 30,
) -> OutwardPaths:
    """Follow sequences of poses of one hand.

    Args:
        robot: the robot, in the frame of the targets.
        hand: the hand.
        position: of its tool centre point, m.
        rotation: its orientation.
        first: configurations at the hardest moment, as they were solved there.
        hardest: that moment, from which both ends are followed to.
        give_up: whether a path that breaks is not followed further; else it is, however far it stays away.
        iterations: most steps of inverse kinematics in each stage.
    """
    count, moments = position.shape[:2]
    joints = np.flatnonzero(robot.frame_joints(robot.arms[hand].tcp_frame))
    path = np.full((count, moments, first.shape[-1]), np.nan)
    miss = np.full((count, moments), np.inf)
    path[:, hardest], miss[:, hardest] = first, 0.0
    broken_at = np.full(count, -1)
    for step in range(1, moments):
        ends = [m for m in (hardest - step, hardest + step) if 0 <= m < moments]
        alive = np.flatnonzero(broken_at < 0) if give_up else np.arange(count)
        if not ends or len(alive) == 0:
            break
        which, at = np.tile(alive, len(ends)), np.repeat(ends, len(alive))
        before = path[which, at - np.sign(at - hardest)]
        solution = solve_hand(robot, hand, position[which, at], rotation[which, at], before, iterations)
        path[which, at], miss[which, at] = solution.configurations, distance_missed(solution)
        jump = np.abs(solution.configurations - before)[:, joints].max(axis=1, initial=0.0)
        broken = ~(solution.reached() & (jump < LARGEST_JUMP)) & (broken_at[which] < 0)
        broken_at[which[broken]] = at[broken]
    return OutwardPaths(path, miss, broken_at)


def solve_hand(
    robot: Robot,
    hand: ArmName,
    position: Float[np.ndarray, "poses 3"],
    rotation: Float[np.ndarray, "poses 3 3"],
    start: Float[np.ndarray, "poses joints"],
    iterations: int = 30,
) -> PoseSolution:
    """Solve poses of one hand, positions in m, near their starts; any number of them."""
    parts = [
        solve_poses(
            robot,
            [hand],
            position[begin : begin + MOST_AT_ONCE, None],
            rotation[begin : begin + MOST_AT_ONCE, None],
            start[begin : begin + MOST_AT_ONCE],
            pull=PULL,
            iterations=iterations,
        )
        for begin in range(0, len(start), MOST_AT_ONCE)
    ]
    if not parts:
        return PoseSolution(np.empty_like(start), np.empty(0), np.empty(0))
    return PoseSolution(
        np.concatenate([part.configurations for part in parts]),
        np.concatenate([part.position_error for part in parts]),
        np.concatenate([part.rotation_error for part in parts]),
    )


def distance_missed(solution: PoseSolution) -> Float[np.ndarray, " poses"]:
    """How far off solved poses are, m; a radian of orientation counts 0.25 m."""
    return np.hypot(solution.position_error, ROTATION_LENGTH * solution.rotation_error)
