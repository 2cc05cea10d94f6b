"""Showing a model: one that this version cannot read."""

from pathlib import Path


def test_a_model_of_a_later_version(learned, here, refused) -> None:
    Path("later.json").write_text(learned.read_text().replace('"format_version": 1', '"format_version": 9'))
    for verb in (["show", "later.json"], ["plan", "later.json", "--scene", "built-in:rolling", "-o", "out"]):
        assert "format version 9 is later than 1" in refused(*verb)
