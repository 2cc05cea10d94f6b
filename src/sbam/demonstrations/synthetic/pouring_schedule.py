"""When a pouring person does what: onsets and durations of the sub-movements, drawn anew for each demonstration."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sbam.demonstrations.synthetic.motion import PEAK_SPEED_RATIO, minimum_jerk
from sbam.demonstrations.synthetic.person import HandTimes

FLOWING = np.deg2rad(60.0)
"""Tilt above which liquid is taken to flow, rad; the mouth leaves the rim only as it stops."""

Span = tuple[float, float]
"""Onset and duration, s."""


@dataclass(frozen=True)
class PouringSchedule:
    """Sub-movements of one pouring, each as onset and duration, s.

    Attributes:
        left: times of the hand with the cup.
        right: times of the hand with the bottle.
        cup_raise: the cup is taken to where it is poured into.
        cup_lower: the cup is put back.
        carry: the mouth is led beside the rim.
        tilt: the bottle tilts.
        tilt_back: the bottle turns upright.
        leave: the mouth leaves the rim.
        carry_back: the bottle is put back.
        end: end of the demonstration, s.
    """

    left: HandTimes
    right: HandTimes
    cup_raise: Span
    cup_lower: Span
    carry: Span
    tilt: Span
    tilt_back: Span
    leave: Span
    carry_back: Span
    end: float


def draw_schedule(
    rng: np.random.Generator, tempo: float, distance: float, across: bool, tilt: float
) -> PouringSchedule:
    """Draw a schedule: the hands are asynchronous, react after delays, and overlap as far as they do not collide.

    Args:
        rng: source of all variation.
        tempo: factor on durations; above 1 is slower.
        distance: from cup to bottle at the start, m.
        across: whether the bottle stands beyond the cup, so that the right hand fetches it past the cup before the
            left hand reaches out, and takes it back after the left hand has let go.
        tilt: largest tilt of the bottle, rad.
    """
    draw = rng.uniform
    tempo = tempo * draw(0.93, 1.0 if across else 1.06)
    way = distance + (0.35 if across else 0.0)
    left_reach, left_retreat = (0.55 + (0.4 if across else 0.25)) * tempo * draw(0.9, 1.15, 2)
    right_reach, right_retreat = (0.55 + (0.5 if across else 0.3)) * tempo * draw(0.9, 1.15, 2)
    left_closes, right_closes = draw(0.12, 0.3, 2)
    carry = (0.60 + 0.95 * way) * draw(0.9 if across else 0.75, 1.1) * tempo

    lag = carry * draw(0.5, 0.6) + 0.75 * tempo if across else -draw(0.1, 0.85) * tempo  # of the cup
    bottle_lift = draw(0.25, 0.5) + max(right_closes + right_reach, left_closes + left_reach - lag)
    cup_lift = bottle_lift + lag
    raise_cup = draw(1.35, 1.65) * tempo * (0.92 if across else 1.0)

    # The tilt begins under way, but the mouth must have arrived, and the cup nearly so, before liquid flows.
    tilt_up = PEAK_SPEED_RATIO * tilt / np.deg2rad(draw(140.0, 235.0))
    tilt_down = PEAK_SPEED_RATIO * tilt / np.deg2rad(draw(165.0, 245.0))
    arrival = draw(0.25, 0.52) * tilt_up
    tilt_on = max(
        bottle_lift + draw(0.1, 0.8) * tempo,
        bottle_lift + carry - arrival,
        cup_lift + raise_cup - 0.6 * tilt_up,
    )
    if not across:  # across, the bottle waits beside the cup; else people slow down rather than wait
        carry = tilt_on + arrival - bottle_lift
    back_on = tilt_on + tilt_up + draw(0.5, 1.1 if across else 1.6)
    flow_stops = back_on + tilt_down * _phase(1.0 - FLOWING / tilt)

    lower_on, lower = back_on + draw(0.2, 0.45) + (0.15 if across else 0.0), draw(1.15, 1.45) * tempo
    cup_place = lower_on + lower
    carry_back = (0.72 + 0.75 * way) * draw(1.0 if across else 0.9, 1.15) * tempo
    down_on = cup_place + draw(0.2, 0.35) if across else flow_stops + tilt_down * draw(0.0, 0.2)
    bottle_place = down_on + carry_back

    left_leaves, right_leaves = cup_place + draw(0.12, 0.3), bottle_place + draw(0.12, 0.3)
    left_grasp, right_grasp = cup_lift - left_closes, bottle_lift - right_closes
    left = HandTimes(left_grasp - left_reach, left_grasp, cup_lift, cup_place, left_leaves, left_leaves + left_retreat)
    right = HandTimes(
        right_grasp - right_reach, right_grasp, bottle_lift, bottle_place, right_leaves, right_leaves + right_retreat
    )
    return PouringSchedule(
        left,
        right,
        cup_raise=(cup_lift, raise_cup),
        cup_lower=(lower_on, lower),
        carry=(bottle_lift, carry),
        tilt=(tilt_on, tilt_up),
        tilt_back=(back_on, tilt_down),
        leave=(flow_stops - draw(0.24, 0.28) * tilt_down, (1.35 if across else 1.15) * tilt_down),
        carry_back=(down_on, carry_back),
        end=max(left.rest, right.rest) + draw(0.2, 0.6),
    )


def _phase(progress: float) -> float:
    """When a minimum-jerk movement has made that progress (0 to 1), as a fraction of its duration."""
    phase = np.linspace(0.0, 1.0, 201)
    return float(np.interp(progress, minimum_jerk(phase, 0.0, 1.0), phase))
