"""Planning from the command line."""

import json
import re
import shutil
from pathlib import Path

import pytest
import yaml

from sbam.cli import main
from sbam.robots import ROBOTS

OBJECTS = {
    "kitchen_sideboard": {"position": [0.545, 0, -0.024], "upright_yaw_deg": 90},
    "cup_small": {"position": [0.46, 0.08, 0], "upright_yaw_deg": 0},
    "milk_small": {"position": [0.48, -0.15, 0], "upright_yaw_deg": 90},
}


def test_plan_writes_trajectory_and_report(learned, here, capsys) -> None:
    arguments = ["plan", str(learned), "--scene", "built-in:pouring_new_layout", "--robot", "panda_dual"]
    assert main([*arguments, "-o", "out", "--json", "report.json", "--formats", "npz", "csv", "ros"]) == 0
    report = json.loads(Path("report.json").read_text())
    assert report["ok"] and report["problems"] == []
    assert {"seconds", "objective", "keypoints", "joint_names", "checks", "files"} <= report.keys()
    assert all(Path(file).is_file() for file in report["files"])
    names = {path.name for path in Path("out").iterdir()}
    assert {"trajectory.npz", "trajectory.csv", "trajectory_ros.json", "report.json", "recording.html"} <= names
    assert [path.name for path in Path("out").iterdir() if path.name.startswith(".")] == []
    assert json.loads(Path("out/report.json").read_text())["objective"] == report["objective"]
    assert "checks passed" in capsys.readouterr().out


def test_a_plan_that_fails_is_written_only_if_wanted(learned, here, capsys, monkeypatch) -> None:
    monkeypatch.setattr("sbam.planning.search.ATTEMPTS", 1)
    robot = Path(shutil.copytree(ROBOTS["panda_dual"].parent, here / "robot"), "panda_dual.yaml")
    robot.write_text(re.sub(r"torque: *[0-9.]+", "torque: 1.0", robot.read_text()))  # too weak for its own arms
    plan = ["plan", str(learned), "--scene", "built-in:pouring_new_layout", "--robot", str(robot), "-o", "out"]
    assert main([*plan, "--json", "report.json"]) == 1
    report = json.loads(Path("report.json").read_text())
    assert not report["ok"] and any("torque limits" in problem for problem in report["problems"])
    assert capsys.readouterr().err.splitlines() == [f"sbam: {problem}" for problem in report["problems"]]
    assert not Path("out").exists()
    assert main([*plan, "--keep-failed", "--plots"]) == 1
    assert list(Path("out/plots").glob("*.png"))
    assert Path("out/trajectory.npz").is_file()
    assert json.loads(Path("out/report.json").read_text())["ok"] is False


def write_scene(path: Path, **changes: object) -> Path:
    objects = {name: {**part, **dict(changes.get(name) or {})} for name, part in OBJECTS.items()}
    objects = {name: part for name, part in objects.items() if changes.get(name, ...) is not None}
    agent = {"position": [0, 0, 0], "heading_deg": 0}
    path.write_text(yaml.safe_dump({"format_version": 1, "agent": agent, "objects": objects}, sort_keys=False))
    return path


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"cup_small": {"position": [460, 80, 0]}}, "looks like mm"),
        ({"cup_small": {"position": [float("nan"), 0.08, 0]}}, "finite number"),
        ({"cup_small": {"model": "cup_huge"}}, "unknown object model 'cup_huge'"),
        ({"cup_small": {"colour": "red"}}, "colour"),
        ({"milk_small": None}, "no object can play the role 'pour_from'"),
        ({"milk_small": {"position": [1.6, -0.15, 0]}}, "milk_small"),
    ],
    ids=["mm", "nan", "unknown", "unknown key", "lacking", "unreachable"],
)
def test_scenes_that_cannot_be_used(learned, here, refused, changes: dict[str, object], said: str) -> None:
    write_scene(here / "scene.yaml", **changes)
    message = refused("plan", str(learned), "--scene", "scene.yaml", "-o", "out")
    assert said in message


def test_unknown_robots_and_roles(learned, here, refused) -> None:
    plan = ["plan", str(learned), "--scene", "built-in:pouring_milk", "-o", "out"]
    assert "panda_dual" in refused(*plan, "--robot", "nobody")
    assert "'pour_from'" in refused(*plan, "--roles", "pour=cup_small")
    assert "lacks 'pour from'" in refused(*plan, "--roles", "pour_from=cup_small")
