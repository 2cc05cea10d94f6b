"""t_s: how far the affordance constraints are from what was learned."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar, Literal

import numpy as np
from jaxtyping import Float, Int

from sbam.constraints import ConstraintType, constraint_type
from sbam.planning.keypoints.state import State
from sbam.planning.keypoints.targets import compared_changes, pair_target, vector_shift
from sbam.planning.keypoints.terms.base import EXACT, Smoothing, Term
from sbam.planning.keypoints.terms.context import TermContext
from sbam.planning.keypoints.terms.rows import Rows, VectorRows
from sbam.planning.keypoints.weights import pair_weights

UNREACHED = 3.0
"""A pair is missed if it is off by this many learned standard deviations more than without a robot."""


@dataclass(frozen=True)
class Similarity(Term):
    r"""t_s: one group per pair of one constraint type (paper, section III-D).

    .. math:: t_s(\theta) = \sum_{i,j} \sqrt{s_{i,j}(\theta)}

    with the similarity :math:`s` of the constraint type (`sbam.constraints.ConstraintType`).

    Attributes:
        constraint: the type, which knows residual and derivative.
        pairs: names.
        first: index of the first region in the workspace.
        second: index of the second region, -1 for own-start pairs.
        origin: where the first region was at the start, agent frame, m; used for own-start pairs.
        shift: added to the vectors, agent frame, m; moves a support's reference point.
        target: learned mean, in the channels' units.
        weight: of each channel.
    """

    name: ClassVar[str] = "similarity"
    loss: ClassVar[Literal["norm", "square"]] = "norm"
    excess_unit: ClassVar[str] = "learned standard deviations"

    constraint: ConstraintType
    pairs: tuple[str, ...]
    first: Int[np.ndarray, " pairs"]
    second: Int[np.ndarray, " pairs"]
    origin: Float[np.ndarray, "pairs 3"]
    shift: Float[np.ndarray, "pairs 3"]
    target: Float[np.ndarray, "keypoints pairs channels"]
    weight: Float[np.ndarray, "keypoints pairs channels"]

    @property
    def most_excess(self) -> float | None:
        """`UNREACHED`; none in mode ``paper``, where a pair's residual is in mm, which no one threshold fits."""
        return UNREACHED if self.constraint.mode == "default" else None

    @cached_property
    def _incidence(self) -> Float[np.ndarray, "pairs regions"]:
        """Matrix that takes the first region centres to vectors: 1 at the first region, -1 at the second."""
        incidence = np.zeros((len(self.pairs), 1 + max(self.first.max(), self.second.max())))
        pairs = np.arange(len(self.pairs))
        incidence[pairs, self.first] = 1.0
        moving = self.second >= 0
        incidence[pairs[moving], self.second[moving]] -= 1.0
        return incidence

    @cached_property
    def _constant(self) -> Float[np.ndarray, "pairs 3"]:
        """What does not move: the shift, and the start of own-start pairs, m."""
        return self.shift - np.where(self.second[:, None] >= 0, 0.0, self.origin)

    def vector(self, state: State) -> Float[np.ndarray, "keypoints pairs 3"]:
        """Vectors first - second, agent frame, m."""
        incidence = self._incidence
        return incidence @ state.region_position[:, : incidence.shape[1]] + self._constant

    def residual(self, state: State, smoothing: Smoothing = EXACT) -> Float[np.ndarray, "keypoints pairs rows"]:
        """Residual of each pair."""
        return self.constraint.residual(self.vector(state), self.target, self.weight, delta_rho=smoothing.rho)

    def _slope(self, state: State, smoothing: Smoothing) -> Float[np.ndarray, "keypoints pairs rows 3"]:
        """Derivative of the residual by the pair's vector."""
        return self.constraint.residual_jacobian(self.vector(state), self.target, self.weight, delta_rho=smoothing.rho)

    def _vector_jacobian(self, state: State) -> Float[np.ndarray, "keypoints pairs 3 joints"]:
        """Derivative of the vectors."""
        w, incidence = state.workspace, self._incidence
        carried = w.carried[w.carried < incidence.shape[1]]
        regions = state.moving_jacobian[:, : len(carried)]
        flat = incidence[:, carried] @ regions.reshape(*regions.shape[:2], -1)
        return flat.reshape(*flat.shape[:2], *regions.shape[2:])

    def jacobian(self, state: State, smoothing: Smoothing = EXACT) -> Float[np.ndarray, "keypoints pairs rows joints"]:
        """By the chain rule through the pair's vector."""
        return self._slope(state, smoothing) @ self._vector_jacobian(state)

    def rows(
        self,
        state: State,
        smoothing: Smoothing,
        residual: Float[np.ndarray, "keypoints pairs rows"],
        norm: Float[np.ndarray, "keypoints pairs"] | None,
    ) -> Rows:
        """The linearised residual; see `VectorRows`."""
        return VectorRows(residual, norm, self._slope(state, smoothing), self._vector_jacobian(state))

    def groups(self) -> tuple[str, ...]:
        """The pairs' names."""
        return self.pairs

    def at(self, keypoint: int, previous: State | None) -> Similarity:
        """The term at one keypoint."""
        k = slice(keypoint, keypoint + 1)
        return replace(self, target=self.target[k], weight=self.weight[k])


def similarity_terms(context: TermContext) -> list[Similarity]:
    """One term per constraint type that occurs in the model."""
    task, times, settings = context.task, context.times, context.settings
    index = {reference: i for i, reference in enumerate(context.regions)}
    terms = []
    for name in sorted({change.constraint for change in task.model.changes}):
        changes = [change for change in compared_changes(task, settings) if change.constraint == name]
        terms.append(
            Similarity(
                constraint=constraint_type(name).in_mode(task.model.mode),
                pairs=tuple(str(change.pair) for change in changes),
                first=np.array([index[change.pair.first] for change in changes]),
                second=np.array([-1 if c.pair.second is None else index[c.pair.second] for c in changes]),
                origin=np.array([task.region_at_start(change.pair.first) for change in changes]),
                shift=np.array([vector_shift(task, change) for change in changes]),
                target=np.stack([pair_target(task, change, times, settings) for change in changes], axis=1),
                weight=np.stack([pair_weights(task.model, c, times, settings.proximity) for c in changes], axis=1),
            )
        )
    return terms
