"""Keypoint by keypoint, as the paper does it, but by gradients: what solving all at once is compared with."""

from __future__ import annotations

import time

import numpy as np
from jaxtyping import Float

from sbam.planning.keypoints.problem import Problem
from sbam.planning.keypoints.solvers.result import Solution, describe
from sbam.planning.keypoints.solvers.whole_trajectory import COLD, WARM, descend
from sbam.planning.keypoints.state import State


def solve_sequentially(problem: Problem, start: Float[np.ndarray, "*keypoints joints"]) -> Solution:
    """Solve each keypoint for itself, the ones before it being settled (paper, section III-D).

    Each is descended to from the keypoint before it, and from its own start if there is one; the better is kept.

    Args:
        problem: what to minimise.
        start: a motion that is nearly right, or the posture before the first keypoint.
    """
    begin = time.perf_counter()
    own = start if start.ndim == 2 else None
    configurations = np.empty((problem.count, start.shape[-1]))
    at: Float[np.ndarray, " joints"] = start[0] if own is not None else start
    previous: State | None = None
    iterations = 0
    for k in range(problem.count):
        here = problem.at(k, previous)
        starts = [(at, WARM if k else COLD)]
        if own is not None:
            starts.append((own[k], WARM))
        found = [descend(here, one[None], schedule) for one, schedule in starts]
        iterations += sum(used for _, used in found)
        previous = min((state for state, _ in found), key=here.merit)
        at = configurations[k] = previous.configurations[0]
    state = problem.state(configurations)
    return describe(problem, state, "sequential", 1, iterations, time.perf_counter() - begin)
