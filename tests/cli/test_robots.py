"""Robots are listed, described and checked."""

import json
from pathlib import Path

from sbam.cli import main
from sbam.robots import ROBOTS


def test_robots_are_listed(capsys) -> None:
    assert main(["robots", "list", "--json", "-"]) == 0
    (robot, *_) = json.loads(capsys.readouterr().out)["robots"]
    assert robot["name"] == "panda_dual" and len(robot["joint_names"]) == 14


def test_own_robots_are_described_and_checked(here, capsys) -> None:
    arm = Path(ROBOTS["panda_dual"]).with_name("panda_arm.xml")
    assert main(["robots", "new", str(arm), "-o", "mine.yaml", "--json", "new.json"]) == 0
    assert "mounted twice" in capsys.readouterr().out
    assert json.loads(Path("new.json").read_text())["file"] == "mine.yaml"
    assert main(["robots", "check", "mine.yaml", "--json", "check.json"]) == 0
    said = capsys.readouterr().out
    assert "left_joint4" in said and "nothing is wrong" in said
    report = json.loads(Path("check.json").read_text())
    assert report["ok"] and report["arms"]["left"]["tcp"] == "left_tcp" and len(report["joints"]) == 14
    assert main(["robots", "check", "armar6"]) == 0
    assert "continuous" in capsys.readouterr().out
    assert main(["robots", "check", "armar8"]) == 1
    assert "'armar6'" in capsys.readouterr().err
