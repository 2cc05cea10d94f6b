"""Showing a model: one that this version cannot read."""

from pathlib import Path

from sbam.learning.model_file import FORMAT_VERSION


def test_a_model_of_a_later_version(learned, here, refused) -> None:
    Path("later.json").write_text(
        learned.read_text().replace(f'"format_version": {FORMAT_VERSION}', '"format_version": 9')
    )
    for verb in (["show", "later.json"], ["plan", "later.json", "--scene", "built-in:rolling", "-o", "out"]):
        assert f"format version 9 is later than {FORMAT_VERSION}" in refused(*verb)
