"""The paper's solver: slow, but it decreases the same objective within the same limits."""

from dataclasses import replace

import numpy as np
import pytest

from sbam.planning.keypoints.solvers.nelder_mead import solve_nelder_mead
from sbam.planning.keypoints.solvers.whole_trajectory import solve_whole_trajectory


def test_two_keypoints(small_plan, problem_of):
    times = small_plan.task.model.keypoint_times
    problem = problem_of(small_plan, times[[12, 14]])
    start = small_plan.solution.configurations[8]
    standing = np.tile(start, (2, 1))
    seen = []
    solution = solve_nelder_mead(problem, start, lambda done, all_of_them: seen.append((done, all_of_them)), 8)
    assert seen == [(1, 2), (2, 2)]
    assert (solution.configurations >= problem.lower).all()
    assert (solution.configurations <= problem.upper).all()
    assert problem.merit(problem.state(solution.configurations)) < problem.merit(problem.state(standing))
    assert solution.iterations <= 2 * 8 * 12 + 2
    assert solution.solver == "paper"
    default = solve_whole_trajectory(problem, [standing, start])
    assert default.objective < solution.objective


def test_nothing_left_to_gain_stays(small_plan, problem_of):
    """From the optimum of one keypoint the simplex finds nothing better."""
    problem = problem_of(small_plan, small_plan.task.model.keypoint_times[[12]])
    optimum = solve_whole_trajectory(problem, [small_plan.solution.configurations[[12]]])
    solution = solve_nelder_mead(problem, optimum.configurations[0], evaluations=2)
    assert solution.objective == pytest.approx(optimum.objective, rel=1e-3)
    assert solution.objective <= optimum.objective


def test_a_person_s_posture_can_be_wanted_too(small_plan, problem_of):
    """The term for human-likeness looks at more frames than the two end effectors, which alone are moved."""
    wanted = replace(small_plan, settings=replace(small_plan.settings, human_likeness=1.0))
    problem = problem_of(wanted, small_plan.task.model.keypoint_times[[12]])
    start = small_plan.solution.configurations[8]
    solution = solve_nelder_mead(problem, start, evaluations=3)
    assert problem.merit(problem.state(solution.configurations)) < problem.merit(problem.state(start[None]))
