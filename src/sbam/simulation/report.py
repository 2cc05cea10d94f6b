"""Machine-readable report of a simulation; its keys are documented in docs/reports.md."""

from __future__ import annotations

from typing import Any

from sbam.planning.report import plain
from sbam.simulation.simulate import SimulationResult

REPORT_VERSION = 1
GRASP_ASSUMED = "grasp assumed: held objects are rigid in the hand from lift to place"


def simulation_report(result: SimulationResult) -> dict[str, Any]:
    """Everything worth knowing of a simulation: dictionaries, lists, text, numbers, booleans and None only."""
    record, arms = result.record, result.action.arms
    report = {
        "report": "simulation",
        "report_version": REPORT_VERSION,
        "ok": result.ok,
        "problems": result.problems,
        "warnings": result.warnings,
        "action": result.action.name,
        "task": result.task,
        "robot": arms.robot.name if arms else None,
        "assumptions": [GRASP_ASSUMED] if arms else ["objects are led along their poses"],
        "values": {key: value for key, value in result.values.items() if key != "series"},
        "yardstick": result.yardstick,
        "tracking_error": record.tracking_error,
        "torque_ratio": record.torque_ratio,
        "slip_m": {f"{hand} hand, {name}": slip for (hand, name), slip in record.slip.items()},
        "contacts": [
            {"first": c.first, "second": c.second, "start_s": c.time, "seconds": c.seconds, "depth_m": c.depth}
            for c in record.contacts
        ],
        "simulated_s": record.simulated,
        "seconds": record.seconds,
        "series": result.values.get("series", {}),
    }
    return plain(report)
