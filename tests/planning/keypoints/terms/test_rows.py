"""The short ways to a linearised residual against the long one over the joints' Jacobian."""

from dataclasses import replace

import numpy as np
import pytest

from sbam.constraints import CONSTRAINT_TYPES
from sbam.planning.keypoints.state import State
from sbam.planning.keypoints.terms import Damping, NormalEquations, Similarity, Smoothing, Smoothness, Term

SMOOTHING = Smoothing(0.3, 3e-2, 3e-3)


def similarity(state: State, constraint: str) -> Similarity:
    """Pairs of all kinds: between carried and standing regions, and from the own start; the last region unused."""
    generator = np.random.default_rng(3)
    kind = CONSTRAINT_TYPES[constraint].in_mode("paper")
    target = generator.normal(size=(len(state.configurations), 4, len(kind.channel_names)))
    return Similarity(
        constraint=kind,
        pairs=("a", "b", "c", "d"),
        first=np.array([0, 3, 1, 2]),
        second=np.array([1, 2, -1, 0]),
        origin=generator.normal(size=(4, 3)),
        shift=np.zeros((4, 3)),
        target=target,
        weight=kind.weights(generator.uniform(0.01, 0.2, target.shape), target),
    )


def terms(state: State) -> dict[str, Term]:
    weight = np.random.default_rng(4).uniform(1.0, 20.0, (len(state.configurations), 2))
    return {
        **{name: similarity(state, name) for name in CONSTRAINT_TYPES},
        "damping": Damping(("a", "b"), weight, np.zeros((2, 3))),
        "smoothness": Smoothness(0.7),
        "smoothness from a start": Smoothness(0.7, np.zeros(state.configurations.shape[1])),
    }


@pytest.mark.parametrize("count", [1, 2, 5])
@pytest.mark.parametrize(
    "name", ["cartesian", "cylindrical", "symbolic", "damping", "smoothness", "smoothness from a start"]
)
def test_rows_are_those_of_the_jacobian(state, name, count):
    state = state.workspace.state(state.configurations[:count])
    term = terms(state)[name]
    residual = term.residual(state, SMOOTHING)
    norm = term.cost(state, SMOOTHING) if term.loss == "norm" else None
    short, long = term.rows(state, SMOOTHING, residual, norm), Term.rows(term, state, SMOOTHING, residual, norm)
    assert type(short) is not type(long)
    generator = np.random.default_rng(5)
    step, other = generator.normal(size=state.configurations.shape), generator.normal(size=residual.shape)
    np.testing.assert_allclose(short.change(step), long.change(step), rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(short.pull(other), long.pull(other), rtol=1e-9, atol=1e-6)
    dual = other / np.linalg.norm(other, axis=-1, keepdims=True) if norm is not None else None
    for z in (None, dual):
        sums = []
        for rows in (short, long):
            normal = NormalEquations(*state.configurations.shape)
            rows.add_to(normal, z, 0.8)
            sums.append(normal.total())
        for field in ("gradient", "diagonal", "coupling"):
            expected = getattr(sums[1], field)
            scale = 1e-10 * max(1.0, float(np.abs(expected).max()))
            np.testing.assert_allclose(getattr(sums[0], field), expected, atol=scale, err_msg=field)


def test_terms_add_up(state):
    some = [terms(state)[name] for name in ("cartesian", "damping", "smoothness")]
    all_rows = []
    for term in some:
        norm = term.cost(state, SMOOTHING) if term.loss == "norm" else None
        all_rows.append(term.rows(state, SMOOTHING, term.residual(state, SMOOTHING), norm))
    together, apart = NormalEquations(*state.configurations.shape), []
    for rows in all_rows:
        rows.add_to(together, None, 1.0)
        alone = NormalEquations(*state.configurations.shape)
        rows.add_to(alone, None, 1.0)
        apart.append(alone.total())
    total = together.total()
    for field in ("gradient", "diagonal", "coupling"):
        np.testing.assert_allclose(getattr(total, field), sum(getattr(part, field) for part in apart), rtol=1e-9)


def test_residuals_that_are_zero_pull_at_nothing(state):
    term = Smoothness(0.7)
    rows = term.rows(state, SMOOTHING, np.zeros((5, 1, state.configurations.shape[1])), None)
    normal = NormalEquations(*state.configurations.shape)
    rows.add_to(normal, None, 1.0)
    assert not normal.total().gradient.any()
    assert not replace(rows, residual=rows.residual + 1.0).pull(np.zeros_like(rows.residual)).any()
