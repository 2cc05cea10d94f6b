"""Learning, and recordings that cannot be learned from."""

import json
from pathlib import Path

import pytest

import sbam
from sbam.cli import main

JUICE = "built-in:synthetic_pouring_juice_right_0"
MILK = "built-in:synthetic_pouring_milk_right_9"


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


def test_modes_and_own_names(here) -> None:
    assert main(["learn", JUICE, "-o", "model.json", "--mode", "paper", "--name", "pour juice"]) == 0
    model = sbam.load_model("model.json")
    assert (model.mode, model.name) == ("paper", "pour juice")


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
def test_damaged_recordings(recording, here, refused, damage: str, said: str) -> None:
    path = damaged(recording, here, damage)
    message = refused("learn", str(path), "-o", "model.json")
    assert said in message and path.name in message


def write_csv(recording: Path, here: Path) -> list[str]:
    assert main(["recordings", "write", str(recording), "-o", str(here), "--format", "csv"]) == 0
    (path,) = here.glob("*.csv")
    lines = path.read_text().splitlines()
    path.unlink()
    return lines


def test_a_recording_that_is_nan_for_long(recording, here, refused) -> None:
    lines = write_csv(recording, here)
    columns = [i for i, name in enumerate(lines[0].split(",")) if name.startswith("apple_juice")]
    assert columns
    for row in range(100, len(lines) - 100):
        cells = lines[row].split(",")
        for column in columns:
            cells[column] = "nan"
        lines[row] = ",".join(cells)
    Path("nan.csv").write_text("\n".join(lines) + "\n")
    message = refused("learn", "nan.csv", "-o", "model.json")
    assert "apple_juice" in message


def test_a_recording_of_one_frame(recording, here, refused) -> None:
    lines = write_csv(recording, here)
    Path("one.csv").write_text("\n".join(lines[:2]) + "\n")
    assert "one frame only" in refused("learn", "one.csv", "-o", "model.json")


def test_an_object_missing_in_one_demonstration(recording, here, refused) -> None:
    lines = write_csv(recording, here)
    kept = [i for i, name in enumerate(lines[0].split(",")) if not name.startswith("cup_large")]
    assert len(kept) < len(lines[0].split(","))
    rows = (line.split(",") for line in lines)
    Path("no_cup.csv").write_text("\n".join(",".join(cells[i] for i in kept) for cells in rows) + "\n")
    message = refused("learn", str(recording), "no_cup.csv", "-o", "model.json")
    assert "'no_cup'" in message and "cup_large" in message


def test_unknown_objects(recording, here, refused) -> None:
    Path("jug.csv").write_text("\n".join(write_csv(recording, here)).replace("apple_juice", "jug") + "\n")
    message = refused("learn", "jug.csv", "-o", "model.json")
    assert "'jug'" in message and "milk_small" in message
