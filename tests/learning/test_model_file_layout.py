"""How a model file reads: one line an array, short things on one line; what cannot be read says why."""

import json
import re

import pytest

from sbam.errors import FileFormatError, FileVersionError
from sbam.learning import learn
from sbam.learning.model_file import FORMAT_VERSION, load_model, save_model


@pytest.fixture(scope="module")
def text(pouring, tmp_path_factory) -> str:
    path = tmp_path_factory.mktemp("model") / "model.json"
    save_model(learn(pouring[:2]), path)
    return path.read_text()


def test_an_array_of_numbers_is_one_line(text):
    lines = text.splitlines()
    arrays = [line.strip() for line in lines if re.match(r'^ *"(time|mean|std|count|value|keypoint_times)": \[', line)]
    assert len(arrays) > 50
    assert max(map(len, arrays)) > 110
    for line in arrays:
        assert isinstance(json.loads(line.rstrip(",").partition(": ")[2]), list), line


def test_what_is_short_is_on_one_line_and_what_is_not_is_indented(text):
    lines = text.splitlines()
    assert lines[:3] == ["{", ' "format": "sbam action model",', f' "format_version": {FORMAT_VERSION},']
    assert (lines[-1], text[-1]) == ("}", "\n")
    for line in lines:
        content = line.strip().rstrip(",")
        if content.endswith(("{", "[")) and not content.startswith(("}", "]")):
            continue
        value = content.partition('": ')[2] or content
        if value[:1] in "{[" and value not in ("{", "[", "}", "]"):
            flat = json.loads(value)
            nested = isinstance(flat, dict) or any(isinstance(item, dict | list | str) for item in flat)
            assert not nested or len(value) <= 110, line
    # Each level is indented by one more.
    depth = 0
    for line in lines:
        content = line.strip()
        depth -= content[0] in "}]"
        assert len(line) - len(line.lstrip()) == depth, line
        depth += content[-1] in "{["


def test_why_a_file_cannot_be_read(tmp_path):
    absent = tmp_path / "absent.json"
    with pytest.raises(FileFormatError, match=r"absent\.json.*cannot be read: No such file or directory"):
        load_model(absent)
    broken = tmp_path / "broken.json"
    broken.write_text("{")
    with pytest.raises(FileFormatError, match=r"broken\.json.*is not valid JSON: .*expected a model written by SBAM"):
        load_model(broken)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"format": None}, r"\$\.format: is None"),
        ({"format_version": None}, r"\$\.format_version"),
        ({"format_version": 1.5}, r"\$\.format_version: is 1\.5.*a whole number"),
    ],
)
def test_what_the_head_of_a_file_must_say(text, tmp_path, change, message):
    path = tmp_path / "changed.json"
    path.write_text(json.dumps({**json.loads(text), **change}))
    with pytest.raises((FileFormatError, FileVersionError), match=message):
        load_model(path)


def test_without_a_version_the_valid_ones_are_said(text, tmp_path):
    content = json.loads(text)
    del content["format_version"]
    path = tmp_path / "changed.json"
    path.write_text(json.dumps(content))
    with pytest.raises(
        FileFormatError, match=rf"changed\.json.*\$\.format_version: is missing.*expected 1 to {FORMAT_VERSION}"
    ):
        load_model(path)


def test_times_are_two_or_more(text, tmp_path):
    content = json.loads(text)
    content["keypoint_times"] = content["keypoint_times"][:1]
    path = tmp_path / "changed.json"
    path.write_text(json.dumps(content))
    with pytest.raises(FileFormatError, match=r"\$\.keypoint_times: does not increase.*2 or more times in order"):
        load_model(path)
