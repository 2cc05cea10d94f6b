"""The report of a plan: stable keys, plain JSON."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sbam.plain import plain
from sbam.planning.keypoints.terms import Closure, Resting
from sbam.planning.plan import Plan
from sbam.planning.report import plan_report

DOCUMENTED = (Path(__file__).parents[2] / "docs" / "reports.md").read_text(encoding="utf-8")


def documented_keys(section: str) -> set[str]:
    """Keys in the first column of the first table after a line that starts with ``section``."""
    after = DOCUMENTED[DOCUMENTED.index(section) :]
    table = re.search(r"\|---.*?\n((?:\|.*\n)+)", after)
    assert table
    return {key for row in table[1].splitlines() for key in re.findall(r"`(\w+)`", row.split("|")[1])}


@pytest.fixture(scope="module")
def report(small_plan: Plan) -> dict:
    return plan_report(small_plan)


def test_the_keys_are_the_documented_ones(report: dict) -> None:
    assert set(report) == documented_keys("## The report of a plan")
    assert all(set(keypoint) == documented_keys("Each of `keypoints`") for keypoint in report["keypoints"])


def test_it_is_plain_json(report: dict) -> None:
    assert json.loads(json.dumps(report, allow_nan=False)) == report


def test_it_says_what_the_plan_holds(small_plan: Plan, report: dict) -> None:
    assert report["ok"] is True
    assert report["problems"] == []
    assert report["joint_names"] == list(small_plan.trajectory.joint_names)
    assert report["roles"] == {"pour_from": "apple_juice", "pour_into": "cup_large", "place_onto": "kitchen_sideboard"}
    assert report["synthetic"] is True
    assert {grasp["hand"] for grasp in report["grasps"]} == {"left", "right"}
    assert report["seconds"]["total"] == pytest.approx(sum(small_plan.seconds.values()))
    assert all(phase["end_s"] > phase["start_s"] for phase in report["phases"])


def test_the_costs_of_the_keypoints_add_up_to_the_objective(report: dict) -> None:
    requirements = {term.name for term in (Resting, Closure)}
    terms = [term for keypoint in report["keypoints"] for term in keypoint["terms"].items()]
    costs = [cost for name, groups in terms if name not in requirements for cost in groups.values()]
    assert sum(costs) == pytest.approx(report["objective"], rel=1e-6)


def test_keypoints_are_passed_in_order(small_plan: Plan, report: dict) -> None:
    times = np.array([keypoint["time_s"] for keypoint in report["keypoints"]])
    assert (np.diff(times) > 0).all()
    assert 0 <= times[0] < times[-1] <= report["duration_s"]
    at = np.interp(times, small_plan.trajectory.time, small_plan.model_time)
    assert np.allclose(at, [keypoint["model_time_s"] for keypoint in report["keypoints"]], atol=1e-3)


def test_what_is_not_finite_becomes_null(small_plan: Plan) -> None:
    solution = replace(small_plan.solution, objective=float("nan"))
    report = plan_report(replace(small_plan, solution=solution))
    assert report["objective"] is None
    json.dumps(report, allow_nan=False)


def test_foreign_types_are_refused() -> None:
    assert plain({"a": np.arange(2), 3: (np.float32(1.5), np.bool_(True), np.inf)}) == {
        "a": [0, 1],
        "3": [1.5, True, None],
    }
    with pytest.raises(TypeError, match="object has no place"):
        plain(object())
