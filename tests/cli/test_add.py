"""Adding recordings to a model."""

from pathlib import Path

import sbam
from sbam.cli import main

JUICE = "built-in:synthetic_pouring_juice_right_0"
MILK = "built-in:synthetic_pouring_milk_right_9"


def test_add_without_output_changes_the_model_in_place(here) -> None:
    assert main(["learn", JUICE, "-o", "model.json"]) == 0
    assert main(["add", "model.json", MILK]) == 0
    assert len(sbam.load_model("model.json").demonstrations) == 2


def test_other_recordings_cannot_be_added(learned, here, refused) -> None:
    Path("model.json").write_bytes(learned.read_bytes())
    message = refused("add", "model.json", "built-in:synthetic_rolling_0")
    assert "pour_from" in message
