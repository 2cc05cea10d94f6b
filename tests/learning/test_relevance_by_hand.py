"""Relevance, pruning and the report of a model of three pairs, worked out by hand."""

from dataclasses import replace

import numpy as np
import pytest

from sbam.constraints import RegionPair, RegionReference
from sbam.learning import LearningSettings
from sbam.learning.generalization import GeneralizedChange, GeneralizedChannel
from sbam.learning.model import ActionModel, Anchor, HandHold, Role
from sbam.learning.relevance import pruned, rank_pairs
from sbam.learning.report import model_report
from sbam.learning.sketch import DemonstrationSketch, SketchedRole

TIME = np.array([0.0, 2.0, 4.0, 10.0])
SPOUT, BRIM, TABLE = (
    RegionReference("jug", "pour from"),
    RegionReference("cup", "pour into"),
    RegionReference("table", "on"),
)


def change(second, stds, mean=0.1, unit="m", constraint="cartesian", units=None) -> GeneralizedChange:
    """Standard deviations (4,) of x alone."""
    means = np.broadcast_to(np.array(mean, dtype=float), (4,))
    channels = []
    for index, name in enumerate("xyz"):
        std = np.array(stds, dtype=float) if index == 0 else np.zeros(4)
        channels.append(
            GeneralizedChannel(name, units[index] if units else unit, TIME, means.copy(), std, np.full(4, 3))
        )
    return GeneralizedChange(RegionPair(SPOUT, second), constraint, tuple(channels))


def model(*changes) -> ActionModel:
    roles = tuple(
        Role(name, (affordance,), name != "table", (f"a {name}",))
        for name, affordance in (("jug", "pour from"), ("cup", "pour into"), ("table", "on"))
    )
    shown = SketchedRole("jug", "a jug", ("pour from",), True)
    return ActionModel(
        name="pour",
        constraint="cartesian",
        mode="default",
        roles=roles,
        changes=changes,
        anchors=(Anchor("start", None, 0.0), Anchor("tilt", "jug", 4.0), Anchor("end", None, 10.0)),
        keypoint_times=np.array([0.0, 4.0, 10.0]),
        holds=(
            HandHold("jug", "right", 1.0, 9.0, np.zeros((2, 3))),
            HandHold("cup", "left", 3.0, 5.0, np.zeros((0, 3))),
        ),
        synthetic=True,
        demonstrations=(DemonstrationSketch("first", 9.5, True, (shown,), (), (), ()),),
        settings=LearningSettings.default(),
        notes=("one thing",),
    )


def test_spreads_in_units_of_the_layouts():
    """At the start 0.10 and 0.30 between two objects: layouts spread by 0.20.

    Jug and cup are nearest at 4 s, 0.02 (0.1 of it), jug and table at 10 s, 0.01; that is after the jug was let go at
    9 s, where it is 0.025 (5/6 of the way from 0.10 at 4 s), about 0.125.
    """
    near, far = change(BRIM, [0.1, 0.1, 0.02, 0.1]), change(TABLE, [0.3, 0.3, 0.1, 0.01])
    first, second = rank_pairs(model(far, near))
    assert (first.pair, second.pair) == (near.pair, far.pair)
    assert (first.layout_spread, second.layout_spread) == (pytest.approx(0.2), pytest.approx(0.2))
    assert first.best_time == pytest.approx(4.0, abs=0.026)
    assert first.spread == pytest.approx(0.1, rel=0.06)
    assert second.best_time == pytest.approx(9.0, abs=0.051)
    assert second.spread == pytest.approx(0.125, rel=0.03)
    assert (first.precision, second.precision) == (1.0, pytest.approx(first.spread / second.spread))
    assert (first.fixed, second.fixed) == (False, False)


def test_what_is_nearer_than_a_tenth_of_the_layouts_is_fixed():
    near, far = change(BRIM, [0.2, 0.2, 0.01, 0.01]), change(TABLE, [0.2, 0.2, 0.2, 0.2])
    first, second = rank_pairs(model(near, far))
    assert (first.fixed, second.fixed) == (True, False)
    assert second.spread == pytest.approx(1.0)
    assert second.precision == pytest.approx(first.spread)


def test_spreads_below_the_floor_count_as_the_floor():
    """5 mm of 0.2 m; 0.05 log units of 2."""
    (length,) = rank_pairs(model(change(BRIM, [0.2, 0.0, 0.0, 0.0])))
    assert (length.spread, length.layout_spread) == (pytest.approx(0.025), pytest.approx(0.2))
    (log,) = rank_pairs(model(change(BRIM, [2.0, 0.0, 0.0, 0.0], unit="log", constraint="symbolic")))
    assert (log.spread, log.layout_spread) == (pytest.approx(0.025), pytest.approx(2.0))
    # With no spread at all, nothing tells one from another.
    (nothing,) = rank_pairs(model(change(BRIM, [0.0] * 4)))
    assert (nothing.spread, nothing.layout_spread, nothing.precision) == (1.0, 0.005, 1.0)


def test_azimuths_count_as_arcs():
    """1 rad at 10 cm."""
    turning = change(BRIM, [0.0] * 4, mean=0.1, units=("m", "rad", "m"))
    channels = list(turning.channels)
    channels[1] = replace(channels[1], std=np.ones(4))
    (found,) = rank_pairs(model(replace(turning, channels=tuple(channels), constraint="cylindrical")))
    assert (found.layout_spread, found.spread) == (pytest.approx(0.1), pytest.approx(1.0))


def test_own_start_pairs_count_from_where_they_are_farthest():
    """Farthest at 4 s: what was precise before does not count. At 4 s 0.08, 9 s 0.0467, of the largest spread, 0.08."""
    own = replace(change(None, [0.0, 0.001, 0.08, 0.04]))
    channels = [replace(c, mean=np.array([0.0, 0.1, 0.4, 0.2])) for c in own.channels]
    (found,) = rank_pairs(model(replace(own, channels=tuple(channels))))
    assert found.layout_spread == pytest.approx(0.08, rel=0.02)
    assert found.best_time == pytest.approx(9.0, abs=0.051)
    assert found.spread == pytest.approx((0.08 - 0.04 * 5 / 6) / 0.08, rel=0.02)
    assert found.precision == 1.0


def test_pruning_by_relative_precision():
    near, far = change(BRIM, [0.2, 0.2, 0.02, 0.02]), change(TABLE, [0.2, 0.2, 0.03, 0.03])
    own = change(None, [0.0, 0.1, 0.1, 0.1])
    found = {entry.pair: entry.precision for entry in rank_pairs(model(near, far, own))}
    assert found[far.pair] == pytest.approx(2 / 3)
    assert [c.pair for c in pruned(model(near, far, own), 0.6).changes] == [near.pair, far.pair, own.pair]
    assert [c.pair for c in pruned(model(near, far, own), 0.7).changes] == [near.pair, own.pair]
    assert [c.pair for c in pruned(model(near, far, own)).changes] == [near.pair, far.pair, own.pair]
    kept = pruned(model(near, far, own), 0.7)
    assert {0.0, 4.0, 10.0} <= set(kept.keypoint_times)
    assert kept.keypoint_times[-1] == 10.0


def test_the_report_of_a_model():
    near, far = change(BRIM, [0.2, 0.2, 0.02, 0.06]), change(TABLE, [0.2, 0.2, 0.2, 0.2])
    report = model_report(model(far, near))
    pairs = report.pop("pairs")
    assert report == {
        "name": "pour",
        "constraint": "cartesian",
        "mode": "default",
        "synthetic": True,
        "duration": 10.0,
        "demonstrations": [{"name": "first", "duration": 9.5, "synthetic": True, "objects": {"jug": "a jug"}}],
        "roles": [
            {"name": "jug", "affordances": ["pour from"], "moves": True, "demonstrated": ["a jug"]},
            {"name": "cup", "affordances": ["pour into"], "moves": True, "demonstrated": ["a cup"]},
            {"name": "table", "affordances": ["on"], "moves": False, "demonstrated": ["a table"]},
        ],
        "anchors": [
            {"kind": "start", "role": None, "time": 0.0},
            {"kind": "tilt", "role": "jug", "time": 4.0},
            {"kind": "end", "role": None, "time": 10.0},
        ],
        "holds": [
            {"role": "jug", "hand": "right", "grasp": 1.0, "release": 9.0, "observations": 2},
            {"role": "cup", "hand": "left", "grasp": 3.0, "release": 5.0, "observations": 0},
        ],
        "keypoints": [0.0, 4.0, 10.0],
        "notes": ["one thing"],
    }
    first, second = rank_pairs(model(far, near))
    assert [pair["pair"] for pair in pairs] == [str(near.pair), str(far.pair)]
    for pair, entry in zip(pairs, (first, second), strict=True):
        assert (pair["precision"], pair["best_time"], pair["spread"]) == (
            entry.precision,
            entry.best_time,
            entry.spread,
        )
        assert (pair["layout_spread"], pair["fixed"]) == (entry.layout_spread, entry.fixed)
        assert pair["constraint"] == "cartesian"
    x, y, z = pairs[0]["channels"]
    assert x == {
        "name": "x",
        "unit": "m",
        "keypoints": 4,
        "smallest_std": 0.02,
        "mean_std": pytest.approx(0.12),
    }
    assert (y["name"], z["smallest_std"], z["mean_std"]) == ("y", 0.0, 0.0)
