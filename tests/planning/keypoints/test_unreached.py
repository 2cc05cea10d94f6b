"""Which keypoints a robot cannot reach, and what stops it."""

from dataclasses import replace

import numpy as np
import pytest

from sbam.planning.keypoints.terms.similarity import UNREACHED
from sbam.planning.keypoints.unreached import REQUIREMENT, unreached


@pytest.fixture
def case(small_plan, problem_of):
    return problem_of(small_plan), small_plan.solution, small_plan.free_flight, small_plan.task.model.keypoint_times


def with_cost(solution, term: str, group: str, keypoint: int, more: float):
    cost = solution.terms[term][group].copy()
    cost[keypoint] += more
    return replace(solution, terms={**solution.terms, term: {**solution.terms[term], group: cost}})


def test_what_is_reached_is_not_mentioned(case):
    problem, solution, free, times = case
    assert unreached(problem, solution, free, times) == []
    assert unreached(problem, free, free, times) == []


def test_a_pair_that_is_missed(case):
    problem, solution, free, times = case
    group = next(name for name in solution.terms["similarity"] if "pour into of pour_into" in name)
    slightly = with_cost(solution, "similarity", group, 7, 0.5 * UNREACHED)
    assert unreached(problem, slightly, free, times) == []
    missed = with_cost(solution, "similarity", group, 7, 5.0 * UNREACHED)
    limits = tuple(("left_joint4", "left_joint6") if k == 7 else () for k in range(problem.count))
    (sentence,) = unreached(problem, replace(missed, active_limits=limits), free, times)
    assert sentence.startswith(f"keypoint 7 at {times[7]:.2f} s is out of reach: similarity of {group}")
    assert sentence.endswith("joints: left_joint4, left_joint6")


def test_a_requirement_that_is_missed(case):
    """Half a square: at 6 times its scale a requirement costs 18."""
    problem, solution, free, times = case
    met = with_cost(solution, "resting", "pour_into", 0, 0.5 * (0.8 * REQUIREMENT) ** 2)
    assert unreached(problem, met, free, times) == []
    missed = with_cost(solution, "resting", "pour_into", 0, 0.5 * (1.5 * REQUIREMENT) ** 2)
    (sentence,) = unreached(problem, missed, free, times)
    assert "keypoint 0" in sentence
    assert "resting of pour_into" in sentence


def test_what_damping_costs_is_no_failure(case):
    problem, solution, free, times = case
    assert unreached(problem, with_cost(solution, "damping", "pour_into", 5, 1e3), free, times) == []


def test_the_worst_keypoint_is_named_once_for_each_pair(case):
    problem, solution, free, times = case
    group = next(iter(solution.terms["similarity"]))
    cost = solution.terms["similarity"][group] + np.linspace(10.0, 20.0, problem.count)
    terms = {**solution.terms, "similarity": {**solution.terms["similarity"], group: cost}}
    free_terms = {**free.terms, "similarity": {**free.terms["similarity"], group: np.zeros(problem.count)}}
    found = unreached(problem, replace(solution, terms=terms), replace(free, terms=free_terms), times)
    assert len(found) == 1
