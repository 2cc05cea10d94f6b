"""Machine-readable report of a simulation; its keys are documented in docs/reports.md."""

from __future__ import annotations

from typing import Any

import numpy as np

from sbam.plain import plain
from sbam.simulation.holding import FINGER_FRICTION
from sbam.simulation.simulate import SimulationResult

REPORT_VERSION = 1
GRASP_ASSUMED = "grasp assumed: held objects are rigid in the hand from lift to place"


def simulation_report(result: SimulationResult) -> dict[str, Any]:
    """Everything worth knowing of a simulation: dictionaries, lists, text, numbers, booleans and None only."""
    record, arms = result.record, result.action.arms
    slips = {f"{hand} hand, {name}": slip for (hand, name), slip in record.slip.items()}
    report = {
        "report": "simulation",
        "report_version": REPORT_VERSION,
        "ok": result.ok,
        "problems": result.problems,
        "warnings": result.warnings,
        "action": result.action.name,
        "task": result.task,
        "robot": arms.robot.name if arms else None,
        "assumptions": [_hold(result)],
        "values": {key: value for key, value in result.values.items() if key != "series"},
        "yardstick": result.yardstick,
        "tracking_error": record.tracking_error,
        "torque_ratio": record.torque_ratio,
        "slip_m": {key: slip.most for key, slip in slips.items()},
        "slip_deg": {key: float(np.rad2deg(slip.most_angle)) for key, slip in slips.items()},
        "contacts": [
            {"first": c.first, "second": c.second, "start_s": c.time, "seconds": c.seconds, "depth_m": c.depth}
            for c in record.contacts
        ],
        "simulated_s": record.simulated,
        "seconds": record.seconds,
        "series": {
            **result.values.get("series", {}),
            "slip": {
                key: {"time [s]": slip.time, "slip [mm]": 1e3 * slip.distance, "turn [deg]": np.rad2deg(slip.angle)}
                for key, slip in slips.items()
            },
        },
    }
    return plain(report)


def _hold(result: SimulationResult) -> str:
    if result.action.arms is None:
        return "objects are led along their poses"
    if result.world.grasp == "weld":
        return GRASP_ASSUMED
    return f"held by contact: each finger presses with {result.world.grasp_force:g} N, friction {FINGER_FRICTION[0]:g}"
