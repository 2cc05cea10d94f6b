"""Asking whether a robot reaches a scene, from the command line."""

import json
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import sbam
from sbam.cli import main
from sbam.planning.placement.search import search_base


@pytest.fixture
def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same search, of fewer places."""
    grid = {"right": np.array([0.0, 0.1]), "forward": np.array([0.0, 0.2, 0.4]), "turn": np.array([0.0])}
    monkeypatch.setattr(sbam, "search_base", partial(search_base, **grid))


def test_a_scene_within_reach(learned, here, coarse, capsys) -> None:
    command = ["reach", str(learned), "--scene", "built-in:pouring_new_layout", "--picture", "map.png"]
    assert main([*command, "--json", "report.json"]) == 0
    report = json.loads(Path("report.json").read_text())
    assert report["ok"] and report["problems"] == []
    assert (report["verb"], report["robot"], report["synthetic"]) == ("reach", "panda_dual", True)
    assert report["here"]["planned"] is True
    assert {one["object"]: one["miss_m"] for one in report["here"]["miss"]} == {"apple_juice": 0.0, "cup_large": 0.0}
    assert report["forward_m"] == [0.0, 0.2, 0.4]
    assert np.shape(report["miss_m"]) == (1, 3, 2)
    assert report["places"] == 6 >= report["places_that_reach"] >= 1
    assert report["files"] == [report["picture"]] == ["map.png"]
    assert Path("map.png").read_bytes().startswith(b"\x89PNG")
    assert "can do it where it stands" in capsys.readouterr().out


def test_a_robot_that_stands_too_far_is_told_where_to_go(learned, here, coarse, capsys) -> None:
    command = ["reach", str(learned), "--scene", "built-in:pouring_new_layout", "--json", "report.json"]
    assert main([*command, "--robot", "panda_dual:forward=-0.4"]) == 1
    report = json.loads(Path("report.json").read_text())
    assert not report["ok"]
    assert report["problems"] == report["sentences"]
    assert capsys.readouterr().err.splitlines() == [f"sbam: {problem}" for problem in report["problems"]]
    assert max(one["miss_m"] for one in report["here"]["miss"]) > 0.01
    assert 0.01 < report["base"]["forward_m"] <= 0.4
    assert any(f"--robot {report['base']['robot']}" in sentence for sentence in report["sentences"])
    assert report["picture"] is None


def test_what_cannot_be_asked_is_said(learned, refused) -> None:
    reach = ["reach", str(learned), "--scene", "built-in:pouring_new_layout"]
    assert "unknown robot 'nobody'" in refused(*reach, "--robot", "nobody")
    assert "lacks 'pour from'" in refused(*reach, "--roles", "pour_from=cup_large")
    assert "'nowhere'; known: 'pouring_milk'" in refused("reach", str(learned), "--scene", "built-in:nowhere")
    assert "no object can play" in refused("reach", str(learned), "--scene", "built-in:rolling")
    assert "missing.json" in refused("reach", "missing.json", "--scene", "built-in:rolling")
