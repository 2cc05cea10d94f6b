"""Linearised residuals worked out by hand, and added up whatever was there before."""

import numpy as np
import pytest

from sbam.planning.keypoints.terms import NormalEquations, Rows, Similarity, Smoothness, Term
from sbam.planning.keypoints.terms.rows import JointRows, StepRows, VectorRows

COUNT, JOINTS = 3, 2


def random_rows(kind: str, generator: np.random.Generator) -> Rows:
    """Three keypoints, two joints."""
    residual = generator.normal(size=(COUNT, 2, 4))
    norm = np.linalg.norm(residual, axis=-1)
    jacobian, previous = generator.normal(size=(COUNT, 8, JOINTS)), generator.normal(size=(COUNT - 1, 8, JOINTS))
    slope, vectors = generator.normal(size=(COUNT, 2, 4, 3)), generator.normal(size=(COUNT, 2, 3, JOINTS))
    return {
        "squares": JointRows(residual, None, jacobian, None),
        "squares of neighbours": JointRows(residual, None, jacobian, previous),
        "norms": JointRows(residual, norm, jacobian, previous),
        "vectors": VectorRows(residual, norm, slope, vectors),
        "vectors of neighbours": VectorRows(residual, norm, slope, vectors, coupled=True),
        "steps": StepRows(generator.normal(size=(COUNT, 1, JOINTS)), None, 1.7, True),
        "steps from the second": StepRows(generator.normal(size=(COUNT, 1, JOINTS)), None, 1.7, False),
    }[kind]


KINDS = [
    "squares",
    "squares of neighbours",
    "norms",
    "vectors",
    "vectors of neighbours",
    "steps",
    "steps from the second",
]


def matrix(normal: NormalEquations) -> np.ndarray:
    """The symmetric matrix of all blocks, (K n, K n)."""
    full = np.zeros((COUNT, JOINTS, COUNT, JOINTS))
    for k in range(COUNT):
        full[k, :, k] = normal.diagonal[k]
        if k:
            full[k, :, k - 1] = normal.coupling[k]
            full[k - 1, :, k] = normal.coupling[k].T
    return full.reshape(COUNT * JOINTS, COUNT * JOINTS)


def dense_jacobian(rows: Rows) -> np.ndarray:
    """(all residuals, K n), by single steps."""
    columns = []
    for k in range(COUNT):
        for joint in range(JOINTS):
            step = np.zeros((COUNT, JOINTS))
            step[k, joint] = 1.0
            columns.append(rows.change(step).ravel())
    return np.stack(columns, axis=1)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("curvature", [None, 0.3, 1.0])
def test_gradient_and_matrix_are_those_of_the_changes(kind, curvature):
    """J^T u and J^T W J by the dense Jacobian, W written out for each group."""
    generator = np.random.default_rng(8)
    rows = random_rows(kind, generator)
    jacobian, residual = dense_jacobian(rows), rows.residual
    size = residual.shape[-1]
    dual = None if curvature is None or rows.norm is None else generator.normal(size=residual.shape) / 4.0
    unit = residual if rows.norm is None else residual / np.linalg.norm(residual, axis=-1, keepdims=True)
    blocks = []
    for k, group in np.ndindex(residual.shape[:2]):
        weight = np.eye(size)
        if rows.norm is not None:
            u, z = unit[k, group], np.zeros(size) if dual is None else dual[k, group]
            weight -= (curvature or 0.0) * (np.outer(z, u) + np.outer(u, z)) / 2.0
            weight /= rows.norm[k, group]
        blocks.append(weight)
    full = np.zeros((residual.size, residual.size))
    for index, weight in enumerate(blocks):
        at = slice(index * size, (index + 1) * size)
        full[at, at] = weight
    if kind.startswith("steps from"):  # the first keypoint has no step, whatever its residual says
        residual = residual.copy()
        residual[0] = 0.0
        unit = residual
    normal = NormalEquations(COUNT, JOINTS)
    rows.add_to(normal, dual, curvature or 0.0)
    normal.total()
    np.testing.assert_allclose(normal.gradient.ravel(), jacobian.T @ unit.ravel(), atol=1e-12)
    np.testing.assert_allclose(matrix(normal), jacobian.T @ full @ jacobian, atol=1e-12)
    other = generator.normal(size=residual.shape)
    np.testing.assert_allclose(rows.pull(other).ravel(), jacobian.T @ other.ravel(), atol=1e-12)


@pytest.mark.parametrize("second", KINDS)
@pytest.mark.parametrize("first", KINDS)
def test_what_was_there_before_stays(first, second):
    """Two kinds of rows, one after the other, make the sum of what each makes alone."""
    generator = np.random.default_rng(9)
    one, other = random_rows(first, generator), random_rows(second, generator)
    both = NormalEquations(COUNT, JOINTS)
    alone = []
    for rows in (one, other):
        dual = None if rows.norm is None else rows.residual / 9.0
        rows.add_to(both, dual, 0.5)
        single = NormalEquations(COUNT, JOINTS)
        rows.add_to(single, dual, 0.5)
        alone.append(single.total())
    both.total()
    np.testing.assert_allclose(both.gradient, alone[0].gradient + alone[1].gradient, atol=1e-12)
    np.testing.assert_allclose(matrix(both), matrix(alone[0]) + matrix(alone[1]), atol=1e-12)


def test_steps_by_hand():
    """Scale 2; one joint goes 1, 3, 6."""
    free, tied = (StepRows(np.array([[[5.0]], [[1.0]], [[7.0]]]), None, 2.0, first) for first in (False, True))
    step = np.array([[1.0], [3.0], [6.0]])
    assert free.change(step).ravel().tolist() == [0.0, 4.0, 6.0]
    assert tied.change(step).ravel().tolist() == [2.0, 4.0, 6.0]
    # 2 (r_k - r_(k+1)).
    assert free.pull(free.residual).ravel().tolist() == [-2.0, -12.0, 14.0]
    assert tied.pull(tied.residual).ravel().tolist() == [8.0, -12.0, 14.0]
    for rows, first in ((free, 4.0), (tied, 8.0)):
        normal = NormalEquations(3, 1)
        rows.add_to(normal, None, 0.0)
        assert normal.total().diagonal.ravel().tolist() == [first, 8.0, 4.0]
        assert normal.coupling.ravel().tolist() == [0.0, -4.0, -4.0]


def test_nothing_added_is_nothing():
    normal = NormalEquations(2, 3).total()
    for array, shape in ((normal.gradient, (2, 3)), (normal.diagonal, (2, 3, 3)), (normal.coupling, (2, 3, 3))):
        np.testing.assert_array_equal(array, np.zeros(shape))


def test_terms_that_do_not_couple_neighbours_say_so(state):
    from sbam.constraints import Cartesian

    still = np.zeros((1, 3))
    term = Similarity(Cartesian(), ("a",), np.array([0]), np.array([-1]), still, still, still[None], still[None] + 1.0)
    with pytest.raises(TypeError, match="term 'similarity' does not couple neighbours"):
        term.previous_jacobian(state)
    assert (Term.couples_neighbours, Smoothness.couples_neighbours) == (False, True)
