"""What has been planned of a motion so far, at even steps of its clock, with the pauses in which all else waits.

The clock of a motion is the model's time axis as long as nothing waits. Where one arm has to let another one pass, the
action comes smoothly to a standstill and goes on afterwards: the clock runs on, the model's time does not.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int
from scipy.interpolate import make_interp_spline

from sbam.demonstrations.demonstration import Hand

STEP = 0.02  # s between the configurations that are solved for
EASE_TICKS = 20  # ticks over which the action comes to a standstill, and again over which it gathers way
CREEP = 1e-3  # rate of the action when it stands still: not zero, so that every model time has one moment


@dataclass(frozen=True)
class Phase:
    """A named stretch of one hand's motion on the clock, s."""

    hand: Hand
    name: str
    start: float
    end: float
    role: str = ""


def lag(ticks: Float[np.ndarray, "*batch"]) -> Float[np.ndarray, "*batch"]:
    """How many ticks of the action are left when it will stand still in so many ticks; also how many it has gone since.

    Its rate changes with the quintic of `sbam.planning.motion.object_path.ease`; this is the integral.
    """
    x = np.clip(ticks / EASE_TICKS, 0.0, 1.0)
    return EASE_TICKS * x**4 * (2.5 - 3.0 * x + x**2) + np.maximum(ticks - EASE_TICKS, 0.0)


@dataclass(frozen=True)
class Timeline:
    """A motion that is being put together.

    Attributes:
        first: tick of the first sample.
        model_time: on the model's axis, s, at every tick.
        configurations: rad or m.
        phases: what each hand does when, as far as it is known.
        notes: a sentence for each standstill.
    """

    first: int
    model_time: Float[np.ndarray, " ticks"]
    configurations: Float[np.ndarray, "ticks joints"]
    phases: tuple[Phase, ...]
    notes: tuple[str, ...] = ()

    @property
    def clock(self) -> Float[np.ndarray, " ticks"]:
        """Times of the ticks, s."""
        return STEP * (self.first + np.arange(len(self.model_time), dtype=np.float64))

    def phase(self, hand: Hand, role: str, name: str) -> Phase:
        """A phase that is known."""
        return next(p for p in self.phases if (p.hand, p.role, p.name) == (hand, role, name))

    def index(self, time: float) -> int:
        """The sample at a time on the clock; may lie outside."""
        return round(time / STEP) - self.first

    def covering(self, begin: int, end: int) -> Timeline:
        """The same, standing still before and after, so that it has samples from index ``begin`` to ``end``."""
        before, after = max(-begin, 0), max(end - len(self.model_time) + 1, 0)
        if not before and not after:
            return self
        count = len(self.model_time)
        index = np.arange(-before, count + after)
        beyond = STEP * (np.minimum(index, 0) + np.maximum(index - count + 1, 0))
        index = index.clip(0, count - 1)
        return replace(
            self,
            first=self.first - before,
            model_time=self.model_time[index] + beyond,
            configurations=self.configurations[index],
        )

    def with_way(
        self, begin: int, joints: Int[np.ndarray, " arm_joints"], values: Float[np.ndarray, "way joints"], phase: Phase
    ) -> Timeline:
        """The same with one arm's columns written from an index on, which must be covered.

        Before an approach and after a retreat the arm stays where that begins or ends.
        """
        path, end = self.configurations.copy(), begin + len(values)
        path[begin:end, joints] = values[:, joints]
        if phase.name == "approach":
            path[:begin, joints] = values[0, joints]
        else:
            path[end:, joints] = values[-1, joints]
        return replace(self, configurations=path, phases=(*self.phases, phase))

    def with_pause(self, index: int, ticks: int, arriving: bool, passing: Hand) -> Timeline:
        """The same with a standstill at an index.

        Args:
            index: where.
            ticks: how long, besides slowing down and gathering way.
            arriving: whether the arm that is let pass is on its way to a grasp; what it does at the index is then after
                the standstill, what others do before. Else the other way round.
            passing: that arm.
        """
        margin = EASE_TICKS // 2 + 1
        old = self.covering(index - margin, index + margin)
        index += self.first - old.first
        halt = index + EASE_TICKS // 2  # where the standstill begins
        lost = (1.0 - CREEP) * (ticks + EASE_TICKS)
        new = np.arange(len(old.model_time) + int(lost), dtype=np.float64)
        source = index + CREEP * (new - index) + (1.0 - CREEP) * (lag(new - halt - ticks) - lag(halt - new))
        columns = np.concatenate([old.model_time[:, None], old.configurations], axis=1)
        moved = make_interp_spline(np.arange(len(columns)), columns, k=3)(source)
        moved = moved.clip(columns.min(axis=0), columns.max(axis=0))

        def later(time: float, hand: Hand) -> float:
            where = time / STEP - old.first
            if abs(where - index) > 0.5:
                return STEP * (old.first + float(np.interp(where, source, new)))
            return STEP * (old.first + halt + (ticks if (hand == passing) == arriving else 0))

        phases = tuple(replace(p, start=later(p.start, p.hand), end=later(p.end, p.hand)) for p in old.phases)
        return replace(old, model_time=moved[:, 0], configurations=moved[:, 1:], phases=phases)
