"""What must hold exactly: objects at rest, closed two-handed grasps."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.planning.keypoints.state import State
from sbam.planning.keypoints.terms import EXACT, Closure, Resting, Term
from sbam.planning.keypoints.terms.requirements import POSITION_SCALE, ROTATION_SCALE


@pytest.fixture
def resting(state: State) -> Resting:
    generator = np.random.default_rng(6)
    count = len(state.configurations)
    return Resting(
        objects=("a", "b"),
        resting=generator.random((count, 2)) < 0.6,
        position=generator.normal(size=(count, 2, 3)),
        rotation=Rotation.random(2 * count, rng=generator).as_matrix().reshape(count, 2, 3, 3),
    )


@pytest.fixture
def closure() -> Closure:
    generator = np.random.default_rng(7)
    return Closure(0, 1, generator.normal(0, 0.3, 3), Rotation.random(rng=generator).as_matrix())


def test_jacobians_of_resting(resting, state, agrees_with_differences, is_the_row_of_the_whole):
    assert 0 < resting.resting.sum() < resting.resting.size
    agrees_with_differences(resting, state)
    is_the_row_of_the_whole(resting, state)


def test_the_rows_of_resting_pull_as_the_jacobian_does(resting, state):
    """Far off, too; the matrix is that of the Jacobian where the rotations' errors are small."""
    residual = resting.residual(state)
    rows, exact = resting.rows(state, EXACT, residual, None), Term.rows(resting, state, EXACT, residual, None)
    np.testing.assert_allclose(rows.pull(residual), exact.pull(residual), rtol=1e-9, atol=1e-3)
    turn = Rotation.from_rotvec([1e-4, -2e-4, 1e-4]).as_matrix()
    near = replace(resting, rotation=state.object_rotation @ turn)
    step = np.random.default_rng(7).normal(size=state.configurations.shape)
    rows, exact = near.rows(state, EXACT, residual, None), Term.rows(near, state, EXACT, residual, None)
    scale = float(np.abs(exact.change(step)).max())
    np.testing.assert_allclose(rows.change(step), exact.change(step), atol=2e-4 * scale)


@pytest.mark.parametrize("holder", [0, 1])
def test_jacobian_of_closure(holder, closure, state, agrees_with_differences, is_the_row_of_the_whole):
    term = Closure(holder, 1 - holder, closure.position, closure.rotation)
    agrees_with_differences(term, state)
    is_the_row_of_the_whole(term, state)


def test_resting_counts_displacements_in_its_scales(state):
    """1 mm and 10 mrad off: 5 scales each, half of 25 + 25."""
    displaced = Rotation.from_rotvec([0.0, 0.0, -0.010]).as_matrix() @ state.object_rotation
    resting = np.array([[True, False]] * len(displaced))
    term = Resting(("a", "b"), resting, state.object_position - [0.0, 0.001, 0.0], displaced)
    residual = term.residual(state)
    np.testing.assert_allclose(residual[:, 0, :3], np.tile([0.0, 0.001 / POSITION_SCALE, 0.0], (5, 1)), atol=1e-9)
    np.testing.assert_allclose(residual[:, 0, 3:], np.tile([0.0, 0.0, 0.010 / ROTATION_SCALE], (5, 1)), atol=1e-9)
    np.testing.assert_allclose(term.cost(state), np.tile([25.0, 0.0], (5, 1)), atol=1e-9)


def test_closure_is_zero_where_the_second_hand_holds(state):
    """The second hand's actual pose in the object, by scipy, is a grasp that it keeps; 3 mm beside, it is off by 15."""
    k = state.kinematics
    hand = RigidTransform.from_components(k.position[2, 1], Rotation.from_matrix(k.rotation[2, 1]))
    held = state.object_poses()["object of the left hand"][2].inv() * hand
    exact = Closure(0, 1, held.translation, held.rotation.as_matrix())
    assert np.abs(exact.residual(state)[2]).max() < 1e-8
    assert np.abs(exact.residual(state)[[0, 1, 3, 4]]).max() > 10.0
    beside = Closure(0, 1, held.translation + np.array([0.003, 0.0, 0.0]), held.rotation.as_matrix())
    assert np.linalg.norm(beside.residual(state)[2, 0, :3]) == pytest.approx(0.003 / POSITION_SCALE)


def test_requirements_are_no_part_of_the_objective(small_plan, problem_of: Callable):
    problem = problem_of(small_plan)
    q = small_plan.solution.configurations.copy()
    at_start = problem.at(0, None)
    aside = at_start.state(q[:1] + 0.01)
    requirement = next(term for term in at_start.terms if term.is_requirement)
    assert isinstance(requirement, Resting)
    difference = at_start.merit(aside) - at_start.objective(aside)
    assert difference == pytest.approx(float(requirement.cost(aside).sum()))
    assert difference > 100.0
