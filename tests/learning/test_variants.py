"""Demonstrations in different orders are not averaged; the scene's layout chooses."""

import numpy as np
import pytest

import sbam
from sbam.demonstrations.events import Event, EventKind
from sbam.learning.sketch import DemonstrationSketch
from sbam.learning.variants import CLEAR, order_groups

DEMONSTRATIONS = sbam.built_in_demonstrations("pouring")
LEFT = {demonstration.name for demonstration in DEMONSTRATIONS if "left" in demonstration.name}


def sketch(lag: float | None, place_lag: float = 0.0) -> DemonstrationSketch:
    """Two objects, the second lifted ``lag`` after the first, placed ``place_lag`` after it; None: never."""
    times: list[tuple[EventKind, str, float]] = [("lift", "a", 2.0), ("place", "a", 8.0)]
    if lag is not None:
        times.append(("lift", "b", 2.0 + lag))
        times.append(("place", "b", 8.0 + place_lag))
    events = tuple(Event(kind, role, time, np.array([1.0, 0.0, 0.0]), 1.0) for kind, role, time in times)
    return DemonstrationSketch("x", 10.0, True, (), events, (), ())


@pytest.fixture(scope="module")
def model():
    return sbam.learn(DEMONSTRATIONS)


def test_orders_that_are_clearly_swapped_are_groups():
    groups = order_groups([sketch(0.4), sketch(-0.6), sketch(0.1), sketch(-1.0)])
    assert groups[0] == groups[2] != groups[1] == groups[3]


@pytest.mark.parametrize(
    "lags",
    [
        (0.2, 0.4, 0.1, 0.9),  # one order
        (0.2, -0.2, 0.1, -0.1),  # at about the same time, in any order
        (0.4, -1.0, 0.1, 0.3),  # a single exception
        (0.4, None, -1.0, -0.9),  # one demonstration lacks the object
    ],
)
def test_others_are_not(lags):
    assert not order_groups([sketch(lag) for lag in lags]).any()


def test_the_order_of_placing_counts_as_well():
    assert order_groups([sketch(0.1, lag) for lag in (-1.0, 0.2, -0.8, 0.3)]).any()
    assert not order_groups([sketch(0.1, lag) for lag in (-0.5 * CLEAR, 0.2, -0.8, 0.3)]).any()


def test_too_small_groups_are_not_split():
    lags = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)]  # each order alone is shown twice, both once
    assert not order_groups([sketch(*both) for both in lags]).any()


def test_the_bottle_beyond_the_cup_is_another_order(model):
    groups = order_groups(model.demonstrations)
    assert {s.name for s, group in zip(model.demonstrations, groups, strict=True) if group == groups[6]} == LEFT
