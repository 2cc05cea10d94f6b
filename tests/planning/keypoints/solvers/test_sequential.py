"""Keypoint by keypoint: each is an optimum by itself, all together are none."""

import numpy as np
import pytest

from sbam.planning.keypoints.solvers.sequential import solve_sequentially
from sbam.planning.keypoints.solvers.whole_trajectory import WARM, descend, solve_whole_trajectory
from sbam.planning.plan import plan
from sbam.planning.settings import PlanSettings
from sbam.planning.start import in_agent_frame


def test_each_keypoint_is_an_optimum_given_those_before(small_plan, problem_of):
    problem = problem_of(small_plan)
    solution = solve_sequentially(problem, small_plan.solution.configurations)
    assert solution.solver == "sequential"
    assert (solution.configurations >= problem.lower).all()
    assert (solution.configurations <= problem.upper).all()
    previous = None
    for k, q in enumerate(solution.configurations):
        here = problem.at(k, previous)
        state = here.state(q[None])
        again, _ = descend(here, q[None], WARM)
        assert here.merit(again) > 0.99 * here.merit(state) - 1e-3
        previous = state


def test_all_at_once_ends_no_higher(small_plan, problem_of):
    problem = problem_of(small_plan)
    solution = solve_sequentially(problem, small_plan.solution.configurations)
    found = problem.merit(problem.state(solution.configurations))
    together = solve_whole_trajectory(problem, [solution.configurations])
    assert problem.merit(problem.state(together.configurations)) <= found * (1.0 + 1e-6)


def test_one_posture_is_start_enough(small_plan, problem_of):
    times = small_plan.task.model.keypoint_times
    problem = problem_of(small_plan, times[[12, 13]])
    start = small_plan.solution.configurations[11]
    solution = solve_sequentially(problem, start)
    assert solution.objective < problem.objective(problem.state(np.tile(start, (2, 1))))


def test_a_whole_plan(small_plan):
    settings = PlanSettings(solver="sequential")
    found = plan(small_plan.task.model, small_plan.task.scene, in_agent_frame(small_plan.robot), settings)
    assert found.ok
    assert (found.solution.solver, found.free_flight.solver) == ("sequential", "sequential")
    assert found.solution.objective == pytest.approx(small_plan.solution.objective, rel=0.05)
