"""Problems with known optima, and an independent solver."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from sbam.planning.keypoints.problem import Problem
from sbam.planning.keypoints.solvers.linearization import evaluate, linearize
from sbam.planning.keypoints.state import State
from sbam.planning.keypoints.terms import EXACT, Smoothing, Term


@dataclass(frozen=True)
class Tether(Term):
    """|q - wanted|^2 / 2: with smoothness a linear least-squares problem."""

    name = "tether"
    wanted: np.ndarray

    def residual(self, state: State, smoothing: Smoothing = EXACT) -> np.ndarray:
        return (state.configurations - self.wanted)[:, None]

    def jacobian(self, state: State, smoothing: Smoothing = EXACT) -> np.ndarray:
        count, joints = self.wanted.shape
        return np.broadcast_to(np.eye(joints), (count, 1, joints, joints))

    def groups(self) -> tuple[str, ...]:
        return ("tether",)

    def at(self, keypoint: int, previous: State | None) -> "Tether":
        return Tether(self.wanted[keypoint : keypoint + 1])


@pytest.fixture(scope="session")
def tether() -> type[Tether]:
    return Tether


@pytest.fixture(scope="session")
def slsqp() -> Callable[[Problem, np.ndarray], float]:
    """``slsqp(problem, start)``: the exact merit that scipy's SLSQP reaches with the analytic gradient."""
    from scipy.optimize import minimize

    nearly_exact = Smoothing(1e-6, 1e-6, 1e-9)

    def solve(problem: Problem, start: np.ndarray) -> float:
        def merit(flat: np.ndarray) -> tuple[float, np.ndarray]:
            state = problem.state(problem.project(flat.reshape(start.shape)))
            at = evaluate(problem, state, nearly_exact)
            return at.merit, linearize(problem, at, nearly_exact).gradient.ravel()

        bounds = list(zip(np.tile(problem.lower, len(start)), np.tile(problem.upper, len(start)), strict=True))
        options = {"maxiter": 200, "ftol": 1e-10}
        found = minimize(merit, start.ravel(), jac=True, method="SLSQP", bounds=bounds, options=options)
        return problem.merit(problem.state(problem.project(found.x.reshape(start.shape))))

    return solve
