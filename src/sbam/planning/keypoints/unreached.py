"""Which keypoints a robot cannot reach, and what stops it."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from sbam.planning.keypoints.problem import Problem
from sbam.planning.keypoints.solvers.result import Solution

# A requirement counts as missed at this many times its scale of 0.2 mm and 2 mrad.
REQUIREMENT = 5.0


def unreached(
    problem: Problem, solution: Solution, free: Solution, times: Float[np.ndarray, " keypoints"]
) -> list[str]:
    """Keypoints that the robot cannot reach, with the term and the joints that stop it.

    A keypoint counts as unreached if a requirement is off by more than its tolerance, or if a group of another term
    costs more than it would without a robot by what the term says (`Term.most_excess`).
    """
    sentences = []
    for term in problem.terms:
        for group in term.groups():
            cost = solution.terms[term.name][group]
            limit, unit = term.most_excess, term.excess_unit
            if term.is_requirement:
                excess = np.sqrt(2.0 * cost)  # in scales of the requirement: 0.2 mm, 2 mrad
                limit, unit = REQUIREMENT, "times its scale of 0.2 mm and 2 mrad"
            elif limit is not None and group in free.terms.get(term.name, {}):
                excess = cost - free.terms[term.name][group]
            else:
                continue
            worst = int(np.argmax(excess))
            if excess[worst] > limit:
                joints = ", ".join(solution.active_limits[worst]) or "none at its limit: the arm is too short"
                sentences.append(
                    f"keypoint {worst} at {times[worst]:.2f} s is out of reach: {term.name} of {group} is off by "
                    f"{excess[worst]:.1f} {unit}; joints: {joints}"
                )
    return sentences
