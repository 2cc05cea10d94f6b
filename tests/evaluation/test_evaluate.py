"""The whole evaluation, also from the command line."""

import json
from pathlib import Path

import pytest

from sbam.cli import main
from sbam.demonstrations.synthetic import built_in_demonstrations
from sbam.evaluation.evaluate import recordings_for


@pytest.fixture(scope="module")
def rolling() -> list[str]:
    return [f"built-in:{demonstration.name}" for demonstration in built_in_demonstrations("rolling")[:3]]


def test_tasks_and_seeds():
    assert [one.name for one in recordings_for(["rolling"])] == [one.name for one in built_in_demonstrations("rolling")]
    other = recordings_for(["built-in:rolling"], seed=2)
    assert [one.source for one in other] == [one.source for one in built_in_demonstrations("rolling", 2)]


def test_the_verb_writes_tables_and_a_report(rolling, tmp_path: Path, capsys):
    report_file, tables = tmp_path / "report.json", tmp_path / "tables"
    options = ["--robot", "flying_hands", "--constraints", "cartesian", "--mode", "default", "paper", "--jobs", "1"]
    files = ["--cache", str(tmp_path / "cache"), "-o", str(tables), "--json", str(report_file)]
    assert main(["evaluate", *rolling, *options, *files]) == 0
    report = json.loads(report_file.read_text())
    assert (report["ok"], report["synthetic"], report["robot"]) == (True, True, "flying_hands")
    assert len(report["folds"]) == 6
    assert {path.suffix for path in tables.iterdir()} == {".md", ".csv", ".tex"}
    assert sorted(map(str, tables.iterdir())) == sorted(report["files"])
    similarity = next(table for table in report["tables"] if table["name"] == "similarity default/default")
    handles = similarity["rows"][0]
    assert handles[:5] == ["left handle of pin - right handle of pin", "cartesian", 8.762, 5.996, 0.782]
    assert "3 folds, learned from synthetic, tested on synthetic recordings" in similarity["caption"]
    said = capsys.readouterr().out
    assert "left handle of pin" in said
    assert "6 folds in" in said


def test_on_a_robot_from_other_recordings(rolling, tmp_path: Path):
    report_file = tmp_path / "report.json"
    command = ["evaluate", rolling[0], "--train", *rolling[1:], "--constraints", "cartesian", "--fresh", "--jobs", "1"]
    assert main([*command, "--json", str(report_file)]) == 0
    (fold,) = json.loads(report_file.read_text())["folds"]
    assert fold["robot"] == "panda_dual"
    assert fold["training"] == [name.removeprefix("built-in:") for name in rolling[1:]]
    assert fold["values"]["half-strokes"] == 8
    assert fold["problems"] == []


def test_learning_from_a_folder_only_what_shows_an_object(tmp_path: Path):
    names = ["juice_right_0", "juice_right_1", "milk_right_9"]
    folder = tmp_path / "pours"
    pours = [f"built-in:synthetic_pouring_{one}" for one in names]
    assert main(["recordings", "write", *pours, "-o", str(folder), "--format", "npz"]) == 0
    report_file = tmp_path / "report.json"
    options = ["--robot", "flying_hands", "--constraints", "cartesian", "--fresh", "--jobs", "1"]
    command = ["evaluate", "built-in:synthetic_pouring_juice_right_2", "--train", str(folder), *options]
    assert main([*command, "--train-objects", "milk_small", "--json", str(report_file)]) == 0
    (fold,) = json.loads(report_file.read_text())["folds"]
    assert fold["training"] == ["synthetic_pouring_milk_right_9"]
    assert main([*command, "--train-objects", "milk", "--json", str(report_file)]) == 1
    (problem,) = json.loads(report_file.read_text())["problems"]
    assert "unknown object 'milk'" in problem
    assert "'milk_small'" in problem


@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        ([], 2, "give a task"),
        (["rolling", "--jobs", "0"], 2, "--jobs 0"),
        (["rolling", "--seed", "-1"], 2, "--seed -1"),
        (["rolling", "--robot", "nobody"], 1, "unknown robot 'nobody'"),
        (["nowhere.xml"], 1, "nowhere.xml"),
        (["rolling", "--robot", "flying_hands", "--solver", "default", "paper"], 1, "the paper's needs arms"),
    ],
)
def test_what_cannot_be_done_is_said(arguments, code, said, capsys):
    try:
        found = main(["evaluate", *arguments, "--fresh"])
    except SystemExit as end:
        found = end.code
    assert found == code
    assert said in capsys.readouterr().err


def test_a_real_pour_learned_from_synthetic_ones(recordings_folder, tmp_path: Path):
    recording = next((recordings_folder / "kit_bimanual").glob("Pour_files*.xml"))
    report_file = tmp_path / "report.json"
    command = ["evaluate", str(recording), "--train", "pouring", "--robot", "flying_hands", "--fresh", "--jobs", "1"]
    assert main([*command, "--constraints", "cartesian", "--json", str(report_file)]) == 0
    report = json.loads(report_file.read_text())
    assert (report["synthetic"], report["synthetic_training"]) == (False, True)
    (fold,) = report["folds"]
    assert fold["values"]["mouth - rim while pouring [mm]"] < 20.0
    assert fold["values"]["tilted beside the cup for [s]"] == 0.0
