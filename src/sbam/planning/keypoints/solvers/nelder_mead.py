"""The paper's solver: Nelder-Mead over the end-effector poses, keypoint by keypoint, inverse kinematics inside.

It is the baseline that the default solver is measured against, on the same objective.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from sbam.planning.keypoints.problem import Problem
from sbam.planning.keypoints.solvers.result import Solution, describe
from sbam.planning.keypoints.state import State
from sbam.robots.inverse_kinematics import solve_poses

SIMPLEX_POSITION = 0.03  # m: size of the first simplex
SIMPLEX_ROTATION = 0.2  # rad
EVALUATIONS = 150  # at most, per pose parameter and keypoint
POSE_TOLERANCE = 1e-4  # m and rad: the simplex is small enough
MERIT_TOLERANCE = 1e-4  # spread of the objective over the simplex that is small enough


def solve_nelder_mead(
    problem: Problem,
    start: Float[np.ndarray, " joints"],
    progress: Callable[[int, int], None] | None = None,
    evaluations: int = EVALUATIONS,
) -> Solution:
    """Solve keypoint by keypoint with the gradient-free simplex method (paper, section III-D).

    At each keypoint the variables are position and rotation vector (6 numbers) of each end effector relative to the
    previous keypoint's. Every evaluation runs an inverse kinematics from the previous configuration and takes the
    objective of the configuration that it finds, so that what the robot cannot reach is never credited.

    Args:
        problem: what to minimise.
        start: configuration before the first keypoint.
        progress: called with the number of finished keypoints and of all.
        evaluations: of the objective, at most, per pose parameter and keypoint.

    Returns:
        The solution; ``iterations`` counts evaluations of the objective.
    """
    begin = time.perf_counter()
    configurations = np.empty((problem.count, len(start)))
    previous: State | None = None
    count = 0
    current = problem.project(start)
    for k in range(problem.count):
        current, used = _solve_keypoint(problem.at(k, previous), current, evaluations)
        count += used
        configurations[k] = current
        previous = problem.at(k, previous).state(current[None])
        if progress:
            progress(k + 1, problem.count)
    state = problem.state(configurations)
    return describe(problem, state, "paper", 1, count, time.perf_counter() - begin)


def _solve_keypoint(
    problem: Problem, previous: Float[np.ndarray, " joints"], evaluations: int
) -> tuple[Float[np.ndarray, " joints"], int]:
    from scipy.optimize import minimize

    workspace = problem.workspace
    arms = workspace.arms
    origin = problem.state(previous[None]).kinematics
    start_position, start_rotation = origin.position[0, : len(arms)], origin.rotation[0, : len(arms)]
    best = [problem.merit(problem.state(previous[None])), previous]

    def merit(parameters: Float[np.ndarray, " parameters"]) -> float:
        offsets = parameters.reshape(len(arms), 6)
        position = start_position + offsets[:, :3]
        rotation = Rotation.from_rotvec(offsets[:, 3:]).as_matrix() @ start_rotation
        q = solve_poses(
            workspace.robot,
            arms,
            position[None],
            rotation[None],
            best[1],
            reference=previous,
            pull=(1e-2,),
            iterations=15,
        ).configurations
        value = problem.merit(problem.state(q))
        if value < best[0]:
            best[0], best[1] = value, q[0]
        return value

    size = len(arms) * 6
    steps = np.tile(np.repeat([SIMPLEX_POSITION, SIMPLEX_ROTATION], 3), len(arms))
    result = minimize(
        merit,
        np.zeros(size),
        method="Nelder-Mead",
        options={
            "initial_simplex": np.concatenate([np.zeros((1, size)), np.diag(steps)]),
            "maxfev": evaluations * size,
            "xatol": POSE_TOLERANCE,
            "fatol": MERIT_TOLERANCE,
            "adaptive": True,
        },
    )
    return np.asarray(best[1]), int(result.nfev)
