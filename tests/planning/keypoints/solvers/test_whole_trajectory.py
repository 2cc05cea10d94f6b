"""The default solver against known optima and an independent solver."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from sbam.constraints import CONSTRAINT_TYPES
from sbam.planning.keypoints.problem import Problem
from sbam.planning.keypoints.solvers.whole_trajectory import COLD, descend, solve_whole_trajectory
from sbam.planning.keypoints.state import Carrying, RegionPoint, Workspace
from sbam.planning.keypoints.terms import Damping, Similarity, Smoothness


def inside_motion(plan) -> np.ndarray:
    """Keypoints at which everything moves, so that no requirement is at work."""
    times = plan.task.model.keypoint_times
    lift, place = max(m.lift for m in plan.task.moved), min(m.place for m in plan.task.moved)
    return np.flatnonzero((times > lift + 1e-6) & (times < place - 1e-6))


def flying_point(robot, target: np.ndarray, weight: float, damping: float) -> Problem:
    """One hand carries one region; a pair wants it at the targets (K, 3) from the origin, damping holds it there."""
    from scipy.spatial.transform import RigidTransform

    count = len(target)
    workspace = Workspace(robot, [Carrying("cup", "left", RigidTransform.identity())], [RegionPoint(0, np.zeros(3))])
    similarity = Similarity(
        constraint=CONSTRAINT_TYPES["cartesian"],
        pairs=("pair",),
        first=np.array([0]),
        second=np.array([-1]),
        origin=np.zeros((1, 3)),
        shift=np.zeros((1, 3)),
        target=target[:, None],
        weight=np.full((count, 1, 3), weight),
    )
    return Problem(workspace, (similarity, Damping(("cup",), np.full((count, 1), damping), np.zeros((1, 3)))), count)


def test_a_linear_least_squares_problem_within_limits(panda, tether):
    """Tethers to random configurations, half of them outside the limits, and smoothness; scipy's lsq_linear agrees."""
    generator = np.random.default_rng(5)
    count, joints = 6, len(panda.joint_names)
    wanted = generator.uniform(-4.0, 4.0, (count, joints))
    workspace = Workspace(panda, [], [])
    problem = Problem(workspace, (tether(wanted), Smoothness(0.4, panda.home)), count)
    solution = solve_whole_trajectory(problem, [panda.home])
    step = np.eye(count) - np.eye(count, k=-1)
    matrix = np.kron(np.concatenate([np.eye(count), np.sqrt(0.8) * step]), np.eye(joints))
    right = np.concatenate([wanted, np.sqrt(0.8) * np.eye(count)[:, :1] * panda.home]).ravel()
    expected = lsq_linear(matrix, right, (np.tile(problem.lower, count), np.tile(problem.upper, count)), tol=1e-14)
    assert solution.objective == pytest.approx(expected.cost, rel=1e-4)
    np.testing.assert_allclose(solution.configurations.ravel(), expected.x, atol=2e-2)
    assert (expected.active_mask != 0).any()
    names = [panda.joint_names[i] for i in np.flatnonzero(expected.active_mask.reshape(count, joints)[0])]
    assert set(names) <= set(solution.active_limits[0])


def test_where_nothing_conflicts_every_target_is_met(robot_named):
    robot = robot_named("flying_hands")
    target = np.random.default_rng(6).normal(size=(8, 3))
    problem = flying_point(robot, target, weight=200.0, damping=0.0)
    solution = solve_whole_trajectory(problem, [np.zeros(len(robot.joint_names))])
    np.testing.assert_allclose(problem.state(solution.configurations).region_position[:, 0], target, atol=1e-5)
    assert solution.objective < 1e-3


@pytest.mark.parametrize(("weight", "damping", "moves"), [(30.0, 10.0, True), (10.0, 30.0, False)])
def test_a_sum_of_norms_goes_all_the_way_or_not_at_all(robot_named, weight, damping, moves):
    """With w |p - t| + d |p - s| the optimum is t if w > d and s if w < d: on a kink, not in between."""
    robot = robot_named("flying_hands")
    target = np.array([[0.3, -0.2, 0.1]])
    problem = flying_point(robot, target, weight, damping)
    solution = solve_whole_trajectory(problem, [np.full(len(robot.joint_names), 0.05)])
    found = problem.state(solution.configurations).region_position[0, 0]
    np.testing.assert_allclose(found, target[0] if moves else np.zeros(3), atol=2e-4)
    assert solution.objective == pytest.approx(min(weight, damping) * np.linalg.norm(target), rel=2e-4)


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("which", ["pouring", "rolling"])
def test_the_merit_never_rises_and_limits_hold(which, seed, small_plan, rolling_plan, problem_of):
    """Iteration by iteration, at every stage, from 0.3 rad beside the solution."""
    plan = small_plan if which == "pouring" else rolling_plan
    some = slice(3, 18, 5)
    problem = problem_of(plan, plan.task.model.keypoint_times[some])
    near = plan.solution.configurations[some]
    start = problem.project(near + np.random.default_rng(seed).normal(0.0, 0.3, near.shape))
    for stage in COLD:
        staged = problem
        if stage.stiffness:
            staged = replace(problem, terms=(*problem.terms, Smoothness(stage.stiffness)))
        merits = [staged.merit(problem.state(start), stage.smoothing)]
        for iterations in range(1, 15):
            state, _ = descend(problem, start, [stage], max_iterations=iterations)
            merits.append(staged.merit(state, stage.smoothing))
            assert (state.configurations >= problem.lower).all()
            assert (state.configurations <= problem.upper).all()
        assert (np.diff(merits) <= 0.0).all()
        assert merits[-1] < 0.5 * merits[0]


def test_slsqp_does_not_improve_one_keypoint(small_plan, problem_of, slsqp):
    """From the solution by no more than 0.5 %, from random starts by no more than 1 %."""
    generator = np.random.default_rng(8)
    inside = inside_motion(small_plan)
    for index in inside[[0, len(inside) // 2]]:
        problem = problem_of(small_plan, small_plan.task.model.keypoint_times[[index]])
        near = small_plan.solution.configurations[[index]]
        found = solve_whole_trajectory(problem, [near, near[0]])
        merit = problem.merit(problem.state(found.configurations))
        assert merit == pytest.approx(found.objective)
        assert slsqp(problem, found.configurations) > 0.995 * merit
        for _ in range(2):
            assert slsqp(problem, problem.project(near + generator.normal(0, 0.3, near.shape))) > 0.99 * merit


def test_slsqp_does_not_improve_three_keypoints(small_plan, problem_of, slsqp):
    indices = inside_motion(small_plan)[[0, 2, 4]]
    problem = problem_of(small_plan, small_plan.task.model.keypoint_times[indices])
    near = small_plan.solution.configurations[indices]
    found = solve_whole_trajectory(problem, [near, near[0]])
    merit = problem.merit(problem.state(found.configurations))
    assert slsqp(problem, found.configurations) > 0.995 * merit
    start = problem.project(near + np.random.default_rng(9).normal(0, 0.3, near.shape))
    assert slsqp(problem, start) > 0.99 * merit


def test_the_solution_of_the_plan_is_near_the_free_flight(small_plan):
    """No robot can be better than none: what the arms cost is the smoothness of their joints and little more."""
    solution, free = small_plan.solution, small_plan.free_flight
    smoothness = float(solution.terms["smoothness"]["smoothness"].sum())
    assert solution.objective > free.objective - float(free.terms["smoothness"]["smoothness"].sum())
    assert solution.objective < 1.01 * free.objective + smoothness


def test_the_best_of_several_starts_is_kept(small_plan, problem_of):
    problem = problem_of(small_plan, small_plan.task.model.keypoint_times[5:20:5])
    good = small_plan.solution.configurations[5:20:5]
    bad = np.tile(small_plan.robot.home, (problem.count, 1))
    alone = [solve_whole_trajectory(problem, [start]) for start in (bad, good)]
    both = solve_whole_trajectory(problem, [bad, good])
    assert both.objective == min(solution.objective for solution in alone)
    assert both.starts == 2
    assert both.iterations == sum(solution.iterations for solution in alone)
    with pytest.raises(ValueError, match="at least one start"):
        solve_whole_trajectory(problem, [])


def test_one_posture_is_start_enough(small_plan, problem_of):
    """From the posture before the lift as good as from the solution itself."""
    problem = problem_of(small_plan)
    cold = solve_whole_trajectory(problem, [small_plan.solution.configurations[0]])
    warm = solve_whole_trajectory(problem, [small_plan.solution.configurations])
    assert cold.objective < 1.002 * warm.objective
    assert warm.iterations < cold.iterations < 40


def test_the_solution_says_what_it_costs(small_plan, problem_of):
    problem, solution = problem_of(small_plan), small_plan.solution
    state = problem.state(solution.configurations)
    traded = [t.name for t in problem.terms if not t.is_requirement]
    total = sum(cost.sum() for name in set(traded) for cost in solution.terms[name].values())
    assert solution.objective == pytest.approx(float(total))
    assert solution.objective == pytest.approx(problem.objective(state))
    assert {t.name for t in problem.terms} == set(solution.terms)
    assert len(solution.active_limits) == problem.count
    assert solution.seconds > 0.0
