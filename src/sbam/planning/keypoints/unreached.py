"""Which keypoints a robot cannot reach, and what stops it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sbam.planning.keypoints.problem import Problem
from sbam.planning.keypoints.solvers.result import Solution
from sbam.planning.keypoints.terms import Similarity

# A pair counts as missed if its residual exceeds the free flight's by this many learned standard deviations.
UNREACHED = 3.0
# A requirement counts as missed at this many times its scale of 0.2 mm and 2 mrad.
REQUIREMENT = 5.0


def unreached(problem: Problem, solution: Solution, free: Solution, times: NDArray[np.float64]) -> list[str]:
    """Keypoints that the robot cannot reach, with the term and the joints that stop it.

    A keypoint counts as unreached if a requirement is off by more than its tolerance, or a pair by `UNREACHED` more
    than it would be without a robot.
    """
    sentences = []
    # In mode `paper` a pair's residual is in mm by unit weights, which no one threshold fits.
    dimensionless = all(term.constraint.mode == "default" for term in problem.terms if isinstance(term, Similarity))
    requirements = {term.name for term in problem.terms if term.is_requirement}
    for name, groups in solution.terms.items():
        for group, cost in groups.items():
            if name in requirements:
                excess = np.sqrt(2.0 * cost)  # in scales of the requirement: 0.2 mm, 2 mrad
                limit, unit = REQUIREMENT, "times its scale of 0.2 mm and 2 mrad"
            elif name == "similarity" and dimensionless and group in free.terms.get(name, {}):
                excess, limit, unit = cost - free.terms[name][group], UNREACHED, "learned standard deviations"
            else:
                continue
            worst = int(np.argmax(excess))
            if excess[worst] > limit:
                joints = ", ".join(solution.active_limits[worst]) or "none at its limit: the arm is too short"
                sentences.append(
                    f"keypoint {worst} at {times[worst]:.2f} s is out of reach: {name} of {group} is off by "
                    f"{excess[worst]:.1f} {unit}; joints: {joints}"
                )
    return sentences
