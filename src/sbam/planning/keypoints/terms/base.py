"""What an objective term is."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
from jaxtyping import Float

from sbam.planning.keypoints.state import State
from sbam.planning.keypoints.terms.rows import JointRows, Rows


@dataclass(frozen=True)
class Smoothing:
    """How kinks of the objective are rounded while a solver is on its way; all zero is the exact objective.

    Attributes:
        similarity: a group's norm becomes sqrt(s + similarity^2), in units of the weighted residual.
        damping: the same for damping terms, whose norm is exactly zero at many optima.
        rho: the azimuth's radius becomes sqrt(rho^2 + rho_smoothing^2), m.
    """

    similarity: float = 0.0
    damping: float = 0.0
    rho: float = 0.0


EXACT = Smoothing()


class Term(ABC):
    r"""One term of the objective over all K keypoints at once.

    The residual comes in G groups of m rows. With ``loss = "norm"`` each group contributes its Euclidean norm (the
    paper's t_s and t_d are sums of norms), with ``loss = "square"`` half its squared norm:

    .. math::

        t = \sum_{k=1}^{K} \sum_{g=1}^{G} \left\lVert r_{kg}(\theta) \right\rVert
        \qquad\text{or}\qquad
        t = \tfrac12 \sum_{k=1}^{K} \sum_{g=1}^{G} \left\lVert r_{kg}(\theta) \right\rVert^2

    Attributes:
        name: under which it is reported.
        loss: see above.
        couples_neighbours: whether the residual depends on the previous keypoint's configuration too.
        is_requirement: a constraint posed as a stiff penalty: it is met, not traded, and no part of the objective.
        about_posture: whether it is about how a robot holds itself, which says nothing where there is no robot: such
            terms are left out of the free flight, and grasps are preferred that let them be small.
        excess_unit: what the cost of a group counts, in words, where `most_excess` is a number.
    """

    name: ClassVar[str]
    loss: ClassVar[Literal["norm", "square"]] = "square"
    couples_neighbours: ClassVar[bool] = False
    is_requirement: ClassVar[bool] = False
    about_posture: ClassVar[bool] = False
    excess_unit: ClassVar[str] = ""

    @property
    def most_excess(self) -> float | None:
        """How much more a group may cost than without a robot before its keypoint counts as out of reach."""
        return None

    @property
    def frames(self) -> tuple[str, ...]:
        """Frames of the robot that ``State.kinematics`` must hold beside the arms' tool centre points."""
        return ()

    @abstractmethod
    def residual(self, state: State, smoothing: Smoothing = EXACT) -> Float[np.ndarray, "keypoints groups rows"]:
        """Residual; zero is perfect."""

    @abstractmethod
    def jacobian(self, state: State, smoothing: Smoothing = EXACT) -> Float[np.ndarray, "keypoints groups rows joints"]:
        """Derivative of the residual with respect to the keypoint's own configuration."""

    def previous_jacobian(self, state: State) -> Float[np.ndarray, "keypoints groups rows joints"]:
        """Derivative with respect to the previous keypoint's configuration; row 0 is not used."""
        raise TypeError(f"term {self.name!r} does not couple neighbours")

    def rows(
        self,
        state: State,
        smoothing: Smoothing,
        residual: Float[np.ndarray, "keypoints groups rows"],
        norm: Float[np.ndarray, "keypoints groups"] | None,
    ) -> Rows:
        """The linearised residual, given its value and smoothed norm at the state, for solvers."""
        count, joints = state.configurations.shape
        previous = None
        if self.couples_neighbours and count > 1:
            previous = self.previous_jacobian(state)[1:].reshape(count - 1, -1, joints)
        return JointRows(residual, norm, self.jacobian(state, smoothing).reshape(count, -1, joints), previous)

    @abstractmethod
    def groups(self) -> tuple[str, ...]:
        """Names of the G groups, for reports."""

    @abstractmethod
    def at(self, keypoint: int, previous: State | None) -> Term:
        """The term at one keypoint alone, K = 1, given the solved previous keypoint (None at the first)."""

    def epsilon(self, smoothing: Smoothing) -> float:
        """The part of the smoothing that applies to this term's norms."""
        return smoothing.similarity

    def cost(self, state: State, smoothing: Smoothing = EXACT) -> Float[np.ndarray, "keypoints groups"]:
        """Contribution of each group at each keypoint to the objective."""
        squared = np.square(self.residual(state, smoothing)).sum(axis=-1)
        if self.loss == "square":
            return 0.5 * squared
        return np.sqrt(squared + self.epsilon(smoothing) ** 2)
