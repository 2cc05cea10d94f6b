"""The examples in the documentation are true."""

import re
from pathlib import Path

import pytest

from sbam.errors import FileFormatError, UnknownNameError
from sbam.scene import ObjectLibrary, load_object, load_scene

DOCUMENTATION = Path(__file__).parents[1] / "docs"


@pytest.fixture
def examples(tmp_path: Path) -> Path:
    """Folder with the object and the scene of the how-to, as the reader would write them."""
    text = (DOCUMENTATION / "objects_and_scenes.md").read_text(encoding="utf-8")
    tea_box, breakfast = re.findall(r"```yaml\n(.*?)```", text, re.DOTALL)
    (tmp_path / "objects").mkdir()
    (tmp_path / "objects" / "tea_box.yaml").write_text(tea_box)
    (tmp_path / "breakfast.yaml").write_text(breakfast)
    return tmp_path


def test_the_example_object_and_scene_can_be_loaded(examples: Path) -> None:
    library = ObjectLibrary.built_in().with_folder(examples / "objects")
    assert library["tea_box"].affordances == ("place", "pour from")
    scene = load_scene(examples / "breakfast.yaml", library)
    assert scene.objects["breakfast cup"].name == "cup_small"
    assert set(scene.objects) == {"kitchen_sideboard", "tea_box", "breakfast cup"}


def test_the_quoted_errors_are_the_real_ones(examples: Path) -> None:
    text = (DOCUMENTATION / "objects_and_scenes.md").read_text(encoding="utf-8")
    quoted = re.findall(r"```text\n(.*?)```", text, re.DOTALL)[-1].splitlines()
    tea_box, breakfast = examples / "objects" / "tea_box.yaml", examples / "breakfast.yaml"
    library = ObjectLibrary.built_in().with_folder(examples / "objects")

    tea_box.write_text(tea_box.read_text().replace("kind: box", "kind: cube"))
    with pytest.raises(FileFormatError) as kind:
        load_object(tea_box)
    original = breakfast.read_text()
    breakfast.write_text(original.replace("[0.50, -0.15, 0]", "[500, -150, 0]"))
    with pytest.raises(FileFormatError) as millimetres:
        load_scene(breakfast, library)
    breakfast.write_text(original.replace("tea_box:", "teabox:"))
    with pytest.raises(UnknownNameError) as model:
        load_scene(breakfast, library)
    said = [str(error.value) for error in (kind, millimetres, model)]
    said = [message.replace(f"{tea_box.parent}/", "").replace(f"{examples}/", "") for message in said]
    for message, quote in zip(said, quoted, strict=True):
        assert message.startswith(quote.removesuffix(", ..."))


def test_every_page_is_reachable_from_the_index() -> None:
    index = (DOCUMENTATION / "index.md").read_text(encoding="utf-8")
    listed = {
        line.strip() for tree in re.findall(r"```{toctree}(.*?)```", index, re.DOTALL) for line in tree.splitlines()
    }
    assert {path.stem for path in DOCUMENTATION.glob("*.md")} - {"index"} <= listed
