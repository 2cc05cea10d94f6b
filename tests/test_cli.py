"""The command line: what it writes, what it says, and how it ends."""

import json
import os
import re
import resource
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml

import sbam
from sbam.cli import main
from sbam.robots import ROBOTS

JUICE = "built-in:synthetic_pouring_juice_right_0"
MILK = "built-in:synthetic_pouring_milk_right_9"
OBJECTS = {
    "kitchen_sideboard": {"position": [0.545, 0, -0.024], "upright_yaw_deg": 90},
    "cup_small": {"position": [0.46, 0.08, 0], "upright_yaw_deg": 0},
    "milk_small": {"position": [0.48, -0.15, 0], "upright_yaw_deg": 90},
}


@pytest.fixture(scope="session")
def learned(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A model of pouring."""
    path = tmp_path_factory.mktemp("learned") / "pouring.json"
    assert main(["learn", "built-in:pouring", "-o", str(path)]) == 0
    return path


@pytest.fixture(scope="session")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording as MMM file."""
    folder = tmp_path_factory.mktemp("recordings")
    assert main(["recordings", "write", JUICE, "-o", str(folder)]) == 0
    return folder / f"{JUICE.removeprefix('built-in:')}.xml"


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder to work in."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def write_scene(path: Path, **changes: object) -> Path:
    objects = {name: {**part, **dict(changes.get(name) or {})} for name, part in OBJECTS.items()}
    objects = {name: part for name, part in objects.items() if changes.get(name, ...) is not None}
    agent = {"position": [0, 0, 0], "heading_deg": 0}
    path.write_text(yaml.safe_dump({"format_version": 1, "agent": agent, "objects": objects}, sort_keys=False))
    return path


def refused(capsys: pytest.CaptureFixture[str], here: Path, *arguments: str, code: int = 1) -> str:
    """Run a verb that must fail; returns the one line that it says, having left nothing behind."""
    before = {path: path.stat().st_mtime_ns for path in here.rglob("*")}
    capsys.readouterr()
    assert main([*arguments, "--json", "-"]) == code
    out, err = capsys.readouterr()
    report = json.loads(out)
    assert report["ok"] is False
    lines = err.strip().splitlines()
    assert [f"sbam: {' '.join(problem.split())}" for problem in report["problems"]] == lines
    assert len(lines) == 1
    assert "Traceback" not in err
    assert {path: path.stat().st_mtime_ns for path in here.rglob("*")} == before
    return lines[0]


# --- each verb does its job ---


def test_learn_add_show(here, capsys) -> None:
    assert main(["learn", JUICE, "-o", "a/model.json", "--constraints", "cylindrical", "--json", "learn.json"]) == 0
    report = json.loads(Path("learn.json").read_text())
    assert report["ok"] and report["verb"] == "learn" and report["constraint"] == "cylindrical"
    assert report["name"] == "model"
    assert "cylindrical model in mode default from 1 demonstration (synthetic)" in capsys.readouterr().out

    assert main(["add", "a/model.json", MILK, "-o", "both.json"]) == 0
    assert main(["show", "both.json", "--json", "show.json"]) == 0
    assert [len(sbam.load_model(path).demonstrations) for path in ("a/model.json", "both.json")] == [1, 2]
    report = json.loads(Path("show.json").read_text())
    (pouring,) = [role for role in report["roles"] if role["name"] == "pour_from"]
    assert pouring["demonstrated"] == ["apple_juice", "milk_small"]
    assert {hold["hand"] for hold in report["holds"]} == {"left", "right"}
    assert report["anchors"][0]["kind"] == "start"
    spreads = [pair["spread"] for pair in report["pairs"]]
    assert spreads == sorted(spreads)
    text = capsys.readouterr().out
    assert "pour from of pour_from -> pour into of pour_into" in text
    assert main(["show", "both.json", "--plots", "figures", "--json", "plots.json"]) == 0
    plots = json.loads(Path("plots.json").read_text())["plots"]
    assert plots and all(Path(path).stat().st_size > 1000 for path in plots)


def test_add_without_output_changes_the_model_in_place(here) -> None:
    assert main(["learn", JUICE, "-o", "model.json"]) == 0
    assert main(["add", "model.json", MILK]) == 0
    assert len(sbam.load_model("model.json").demonstrations) == 2


def test_modes_and_own_names(here) -> None:
    assert main(["learn", JUICE, "-o", "model.json", "--mode", "paper", "--name", "pour juice"]) == 0
    model = sbam.load_model("model.json")
    assert (model.mode, model.name) == ("paper", "pour juice")


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


def test_a_recording_as_scene_means_its_first_frame(learned, recording, here) -> None:
    assert main(["scenes", "write", str(recording), "-o", "scene.yaml"]) == 0
    scene = sbam.load_scene("scene.yaml")
    (demonstration,) = sbam.load(recording)
    for name, poses in demonstration.T_world_object.items():
        assert np.allclose(scene.T_world_object[name].as_matrix(), poses[0].as_matrix(), atol=1e-9)
    assert np.allclose(scene.T_world_agent.as_matrix(), demonstration.T_world_agent.as_matrix(), atol=1e-9)


def test_a_plan_that_fails_is_written_only_if_wanted(learned, here, capsys, monkeypatch) -> None:
    monkeypatch.setattr("sbam.planning.plan.ATTEMPTS", 1)
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


def test_recordings_list_info_write(here, capsys) -> None:
    assert main(["recordings", "list", "--json", "list.json"]) == 0
    built_in = json.loads(Path("list.json").read_text())["recordings"]
    assert len(built_in) == 20
    assert all(one["synthetic"] and one["rate"] == pytest.approx(100, rel=1e-3) for one in built_in)

    for form, suffix in (("mmm", "xml"), ("npz", "npz"), ("csv", "csv")):
        assert main(["recordings", "write", JUICE, "-o", form, "--format", form]) == 0
        assert [path.suffix for path in Path(form).iterdir()] == [f".{suffix}"]
        assert main(["recordings", "list", form]) == 0
    assert main(["recordings", "info", "mmm", "--json", "info.json"]) == 0
    (info,) = json.loads(Path("info.json").read_text())["recordings"]
    assert info["hands"] == ["left", "right"]
    assert {"lift", "tilt", "place"} <= {event["kind"] for event in info["events"]}
    assert {(hold["hand"], hold["object"]) for hold in info["holds"]} == {
        ("left", "cup_large"),
        ("right", "apple_juice"),
    }
    assert {label["action"] for label in info["labels"]} >= {"Pour", "Hold"}
    assert "note: generated by the project" in capsys.readouterr().out


def test_a_folder_with_a_bad_recording_is_still_listed(recording, here, capsys) -> None:
    Path("good.xml").write_bytes(recording.read_bytes())
    Path("bad.xml").write_text("<MMM")
    assert main(["recordings", "list", "."]) == 0
    out = capsys.readouterr().out
    assert "cannot be used: bad.xml" in out and recording.stem in out


def test_robots_and_scenes_are_listed(capsys) -> None:
    assert main(["robots", "list", "--json", "-"]) == 0
    (robot, *_) = json.loads(capsys.readouterr().out)["robots"]
    assert robot["name"] == "panda_dual" and len(robot["joint_names"]) == 14
    assert main(["scenes", "list"]) == 0
    assert "built-in:pouring_new_layout" in capsys.readouterr().out


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


def test_demo(here, capsys) -> None:
    assert main(["demo", "--json", "demo.json"]) == 0
    report = json.loads(Path("demo.json").read_text())
    assert report["ok"] and report["plan"]["ok"]
    assert {"demonstrate", "learn", "plan", "write"} == report["seconds"].keys()
    written = {str(path) for path in Path("out/demo").rglob("*") if path.is_file()}
    assert written == set(report["files"])
    names = {Path(file).name for file in written}
    assert {"trajectory.npz", "trajectory.csv", "report.json", "model.json", "recording.html"} <= names
    said = capsys.readouterr().out
    for mentioned in ("recording.html", "plots/", "trajectory.csv", "report.json", "model.json"):
        assert f"out/demo/{mentioned}" in said
        assert Path("out/demo", mentioned).exists()
    assert len(said.splitlines()) < 12


# --- bad input: one clear line, exit code, nothing left behind ---


def damaged(recording: Path, here: Path, damage: str) -> Path:
    text = recording.read_text()
    path = here / f"{damage}.xml"
    if damage == "empty":
        path.write_text("")
    elif damage == "truncated":
        path.write_text(text[: len(text) // 3])
    elif damage == "text":
        path.write_text("These are not poses.")
    return path


@pytest.mark.parametrize(
    ("damage", "said"),
    [("empty", "is empty"), ("truncated", "complete XML file"), ("text", "well-formed XML")],
)
def test_damaged_recordings(recording, here, capsys, damage: str, said: str) -> None:
    path = damaged(recording, here, damage)
    message = refused(capsys, here, "learn", str(path), "-o", "model.json")
    assert said in message and path.name in message


def write_csv(recording: Path, here: Path) -> list[str]:
    assert main(["recordings", "write", str(recording), "-o", str(here), "--format", "csv"]) == 0
    (path,) = here.glob("*.csv")
    lines = path.read_text().splitlines()
    path.unlink()
    return lines


def test_a_recording_that_is_nan_for_long(recording, here, capsys) -> None:
    lines = write_csv(recording, here)
    columns = [i for i, name in enumerate(lines[0].split(",")) if name.startswith("apple_juice")]
    assert columns
    for row in range(100, len(lines) - 100):
        cells = lines[row].split(",")
        for column in columns:
            cells[column] = "nan"
        lines[row] = ",".join(cells)
    Path("nan.csv").write_text("\n".join(lines) + "\n")
    message = refused(capsys, here, "learn", "nan.csv", "-o", "model.json")
    assert "apple_juice" in message


def test_a_recording_of_one_frame(recording, here, capsys) -> None:
    lines = write_csv(recording, here)
    Path("one.csv").write_text("\n".join(lines[:2]) + "\n")
    assert "one frame only" in refused(capsys, here, "learn", "one.csv", "-o", "model.json")


def test_an_object_missing_in_one_demonstration(recording, here, capsys) -> None:
    lines = write_csv(recording, here)
    kept = [i for i, name in enumerate(lines[0].split(",")) if not name.startswith("cup_large")]
    assert len(kept) < len(lines[0].split(","))
    rows = (line.split(",") for line in lines)
    Path("no_cup.csv").write_text("\n".join(",".join(cells[i] for i in kept) for cells in rows) + "\n")
    message = refused(capsys, here, "learn", str(recording), "no_cup.csv", "-o", "model.json")
    assert "'no_cup'" in message and "cup_large" in message


def test_unknown_objects(recording, here, capsys) -> None:
    Path("jug.csv").write_text("\n".join(write_csv(recording, here)).replace("apple_juice", "jug") + "\n")
    message = refused(capsys, here, "learn", "jug.csv", "-o", "model.json")
    assert "'jug'" in message and "milk_small" in message


def test_other_recordings_cannot_be_added(learned, here, capsys) -> None:
    Path("model.json").write_bytes(learned.read_bytes())
    message = refused(capsys, here, "add", "model.json", "built-in:synthetic_rolling_0")
    assert "pour_from" in message


def test_a_model_of_a_later_version(learned, here, capsys) -> None:
    Path("later.json").write_text(learned.read_text().replace('"format_version": 1', '"format_version": 9'))
    for verb in (["show", "later.json"], ["plan", "later.json", "--scene", "built-in:rolling", "-o", "out"]):
        assert "format version 9 is later than 1" in refused(capsys, here, *verb)


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
def test_scenes_that_cannot_be_used(learned, here, capsys, changes: dict[str, object], said: str) -> None:
    write_scene(here / "scene.yaml", **changes)
    message = refused(capsys, here, "plan", str(learned), "--scene", "scene.yaml", "-o", "out")
    assert said in message


@pytest.mark.parametrize(
    "arguments",
    [
        ["learn", "nowhere.xml", "-o", "model.json"],
        ["learn", "built-in:dancing", "-o", "model.json"],
        ["show", "nowhere.json"],
        ["recordings", "list", "nowhere"],
        ["scenes", "write", "built-in:dancing", "-o", "scene.yaml"],
        ["scenes", "write", "built-in:pouring", "-o", "scene.yaml"],
    ],
)
def test_what_is_not_there(here, capsys, arguments: list[str]) -> None:
    refused(capsys, here, *arguments)


def test_unknown_robots_and_roles(learned, here, capsys) -> None:
    plan = ["plan", str(learned), "--scene", "built-in:pouring_milk", "-o", "out"]
    assert "panda_dual" in refused(capsys, here, *plan, "--robot", "nobody")
    assert "'pour_from'" in refused(capsys, here, *plan, "--roles", "pour=cup_small")
    assert "lacks 'pour from'" in refused(capsys, here, *plan, "--roles", "pour_from=cup_small")


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["fly"],
        ["learn", "-o", "model.json"],
        ["learn", JUICE],
        ["learn", JUICE, "-o", "model.json", "--constraints", "polar"],
        ["plan", "model.json", "--scene", "scene.yaml", "-o", "out", "--roles", "pour_from"],
        ["plan", "model.json", "--scene", "scene.yaml", "-o", "out", "--speed", "2"],
        ["plan", "model.json", "--scene", "scene.yaml", "-o", "out", "--seed", "-1"],
    ],
)
def test_wrong_usage_ends_with_2(here, capsys, arguments: list[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    assert ended.value.code == 2
    assert capsys.readouterr().err
    assert list(here.iterdir()) == []


# --- as a process ---


def sbam_process(*arguments: str, cwd: Path, **options: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "sbam.cli", *arguments]
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, timeout=120, **options)  # type: ignore[call-overload]


def small_files() -> None:
    """No file may grow beyond 4 kB, as on a disk that is full."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))


@pytest.mark.skipif(sys.platform == "win32", reason="file size limits are POSIX")
@pytest.mark.parametrize("verb", ["learn", "plan"])
def test_a_full_disk(learned, here, verb: str) -> None:
    arguments = {
        "learn": ["learn", JUICE, "-o", "new/model.json"],
        "plan": ["plan", str(learned), "--scene", "built-in:pouring_new_layout", "-o", "new/out"],
    }[verb]
    done = sbam_process(*arguments, cwd=here, preexec_fn=small_files)
    assert done.returncode == 1
    assert done.stderr.startswith("sbam: cannot write") and len(done.stderr.splitlines()) == 1
    assert [path for path in here.rglob("*") if path.is_file()] == []


def test_nothing_heavy_is_imported_for_help(here) -> None:
    heavy = ("scipy", "mujoco", "matplotlib", "viser", "numpy")
    code = f"import sys, sbam, sbam.cli; print(sorted(set(sys.modules) & set({heavy!r})))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
    done = sbam_process("--help", cwd=here)
    assert done.returncode == 0
    for verb in ("learn", "add", "show", "plan", "recordings", "demo"):
        assert verb in done.stdout


def test_an_unexpected_fault_asks_to_be_reported(here, capsys, monkeypatch) -> None:
    def broken(*_: object) -> None:
        raise ZeroDivisionError("division by zero")

    monkeypatch.setattr(sbam, "load", broken)
    monkeypatch.delenv("SBAM_DEBUG", raising=False)
    assert main(["recordings", "info", JUICE]) == 1
    said = capsys.readouterr().err
    assert "please report it" in said and "ZeroDivisionError: division by zero" in said
    monkeypatch.setenv("SBAM_DEBUG", "1")
    with pytest.raises(ZeroDivisionError):
        main(["recordings", "info", JUICE])


def test_an_interruption_ends_with_130(here, capsys, monkeypatch) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(sbam, "load", interrupted)
    assert main(["learn", JUICE, "-o", "model.json"]) == 130
    assert capsys.readouterr().err == "sbam: interrupted\n"
    assert list(here.iterdir()) == []


def test_a_reader_that_stops_early_is_no_fault(here) -> None:
    command = f"{sys.executable} -m sbam.cli recordings list | head -n 1"
    done = subprocess.run(["bash", "-c", command], cwd=here, capture_output=True, text=True, env=os.environ)
    assert "Traceback" not in done.stderr and "fault of sbam" not in done.stderr
