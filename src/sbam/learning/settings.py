"""Settings of the learning: every choice the paper leaves open, and every deviation from it, by name."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from sbam.errors import UnknownNameError

Mode = Literal["default", "paper"]
AlignmentEvent = Literal["reversal", "tilt"]


@dataclass(frozen=True)
class LearningSettings:
    """How demonstrations become a model. `default` is what we think is best, `paper` the paper's way.

    Attributes:
        mode: the weights that the planner gives to the constraints (see `sbam.constraints.ConstraintType`).
        time_alignment: ``events`` maps recurring events (lift, tilt, place...) onto their mean times, ``phase`` only
            start and end, ``seconds`` leaves times as they are.
        alignment_events: with ``events``, the kinds that count beside lifts and places.
        equalize_strokes: with ``events``, cut whole cycles from demonstrations with more strokes than the median and
            leave out those with fewer.
        variants: with ``events``, plan a scene from those demonstrations alone that take and put back their objects in
            the order of the one whose layout is nearest (`sbam.learning.variants`).
        pairs: ``functional`` pairs by affordance names, or ``all`` unordered pairs of regions.
        own_start_pairs: also pair each region of a moved object with its own place at the start.
        supports: pairs against what cannot be moved and is placed onto are Cartesian in models of every type and
            measured in its plane from the ``agent``'s origin (`sbam.learning.generalization.pair_vector`), or like
            others from the ``center`` of its region.
        upright_as_cartesian: models of every type see same-object pairs along the upright axis as Cartesian, because
            their azimuth is undefined while the object stands.
        update_rule: of the standard deviation: exact (``welford``), or the ``paper``'s, which over-estimates.
        segmentation_rate: the data are thinned to this rate before segmentation, Hz; None keeps all of them.
        segmentation_epsilon: a segment is good if its area is below epsilon * amplitude * duration.
        length_amplitude_floor: smallest amplitude of a length for that threshold, m; below it is noise.
        angle_amplitude_floor: the same for angles, rad.
        log_amplitude_floor: the same for log-densities and for other numbers without a dimension.
        gap_cost: cost of leaving a keypoint without a partner; a match costs ``|dt|/duration + |dv|/amplitude``.
        keypoint_bins: bins of the histogram of keypoint candidates.
        keypoint_cutoff: cut-off of its low-pass filter, part of the Nyquist frequency.
        keypoint_prominence: least prominence of its peaks, part of its maximum.
        max_peaks: most peaks that are used (start, end and events come in addition).
    """

    mode: Mode = "default"
    time_alignment: Literal["events", "phase", "seconds"] = "events"
    alignment_events: tuple[AlignmentEvent, ...] = ("reversal", "tilt")
    equalize_strokes: bool = True
    variants: bool = True
    pairs: Literal["functional", "all"] = "functional"
    own_start_pairs: bool = True
    supports: Literal["agent", "center"] = "agent"
    upright_as_cartesian: bool = True
    update_rule: Literal["welford", "paper"] = "welford"
    segmentation_rate: float | None = 12.5
    segmentation_epsilon: float = 0.004
    length_amplitude_floor: float = 0.010
    angle_amplitude_floor: float = 0.1
    log_amplitude_floor: float = 0.2
    gap_cost: float = 0.15
    keypoint_bins: int = 100
    keypoint_cutoff: float = 0.7
    keypoint_prominence: float = 0.01
    max_peaks: int = 30

    @classmethod
    def default(cls) -> LearningSettings:
        """What we think is best."""
        return cls()

    @classmethod
    def paper(cls) -> LearningSettings:
        """As the paper does it (sections III-A to III-C).

        What it leaves open is as in `default`: epsilon, amplitude floors, gap cost, histogram. Its times are taken in
        seconds from the start, because it mentions no normalisation.
        """
        return cls(
            mode="paper",
            time_alignment="seconds",
            equalize_strokes=False,
            variants=False,
            pairs="all",
            own_start_pairs=False,
            supports="center",
            upright_as_cartesian=False,
            update_rule="paper",
            segmentation_rate=None,
        )

    @classmethod
    def for_mode(cls, mode: str) -> LearningSettings:
        """`default` or `paper` by name; raises `UnknownNameError` for others."""
        if mode not in get_args(Mode):
            raise UnknownNameError("mode", mode, get_args(Mode))
        return cls.paper() if mode == "paper" else cls.default()

    def amplitude_floor(self, unit: str) -> float:
        """Amplitude floor of a channel with that unit (`sbam.constraints.base.Unit`)."""
        floors = {
            "m": self.length_amplitude_floor,
            "rad": self.angle_amplitude_floor,
            "log": self.log_amplitude_floor,
            "1": self.log_amplitude_floor,
        }
        return floors[unit]
