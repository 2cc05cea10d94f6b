"""Wrong usage, what is not there, faults and interruptions: one clear line and the right exit code."""

import pytest

import sbam
from sbam.cli import main

JUICE = "built-in:synthetic_pouring_juice_right_0"


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
def test_what_is_not_there(here, refused, arguments: list[str]) -> None:
    refused(*arguments)


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
