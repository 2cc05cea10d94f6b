import json
from dataclasses import fields, is_dataclass, replace
from typing import Any, TypeVar

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform
from typing_extensions import TypeAliasType

from sbam.constraints import CONSTRAINT_TYPES
from sbam.errors import DemonstrationError, FileFormatError, FileVersionError, OutputError
from sbam.learning import LearningSettings, add_demonstration, learn, load_model, save_model
from sbam.learning.model_file import _array_dtype

Number = TypeVar("Number", bound=np.generic)
ALIAS = TypeAliasType("ALIAS", np.ndarray[tuple[Any, ...], np.dtype[Number]], type_params=(Number,))
"""What numpy 2.5 defines NDArray as; before, NDArray[...] is plainly np.ndarray[...]."""


@pytest.fixture(scope="module")
def model(pouring):
    return learn(pouring[:2], name="pour")


@pytest.fixture
def content(model, tmp_path):
    save_model(model, tmp_path / "model.json")
    return json.loads((tmp_path / "model.json").read_text())


def write(tmp_path, content):
    path = tmp_path / "changed.json"
    path.write_text(json.dumps(content))
    return path


@pytest.mark.parametrize("constraint", list(CONSTRAINT_TYPES))
@pytest.mark.parametrize("mode", ["default", "paper"])
def test_round_trip_is_exact(pouring, tmp_path, constraint, mode):
    model = learn(pouring[:3], constraint, mode)
    save_model(model, tmp_path / "one.json")
    loaded = load_model(tmp_path / "one.json")
    save_model(loaded, tmp_path / "two.json")
    assert (tmp_path / "one.json").read_text() == (tmp_path / "two.json").read_text()
    assert loaded.roles == model.roles and loaded.anchors == model.anchors and loaded.settings == model.settings
    for change, again in zip(model.changes, loaded.changes, strict=True):
        for channel, copy in zip(change.channels, again.channels, strict=True):
            for name in ("time", "mean", "std", "count"):
                np.testing.assert_array_equal(getattr(channel, name), getattr(copy, name))
                assert getattr(channel, name).dtype == getattr(copy, name).dtype


@pytest.mark.parametrize("mode", ["default", "paper"])
def test_adding_to_a_loaded_model_is_adding_to_the_model(pouring, tmp_path, mode):
    save_model(learn(pouring[:3], mode=mode), tmp_path / "three.json")
    save_model(add_demonstration(load_model(tmp_path / "three.json"), pouring[3]), tmp_path / "added.json")
    save_model(learn(pouring[:4], mode=mode), tmp_path / "four.json")
    assert (tmp_path / "added.json").read_text() == (tmp_path / "four.json").read_text()


def equal(one, other):
    """Whether two models, or parts of them, are the same, types of numbers included."""
    if is_dataclass(one):
        return type(one) is type(other) and all(
            equal(getattr(one, f.name), getattr(other, f.name)) for f in fields(one)
        )
    if isinstance(one, tuple):
        return len(one) == len(other) and all(map(equal, one, other))
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and np.array_equal(one, other)
    return type(one) is type(other) and one == other


def showing(demonstration, names):
    """The demonstration with these objects alone; a lid stands where the left hand pauses, a mug where none comes."""
    still = {"apple_juice_lid": demonstration.T_world_hand["left"][450].translation, "mug": np.array([0.3, 0.4, 0.9])}
    shown = {
        **demonstration.T_world_object,
        **{
            name: RigidTransform.from_translation(np.tile(place, (len(demonstration.time), 1)))
            for name, place in still.items()
        },
    }
    return replace(demonstration, T_world_object={name: shown[name] for name in sorted(names)})


STEADIED = {"apple_juice", "apple_juice_lid", "kitchen_sideboard"}


def test_a_hold_of_what_is_in_no_watched_pair_is_noted(pouring):
    """The lid is held where it stands, and it is paired with the table alone."""
    model = learn([showing(pouring[0], STEADIED)])
    assert {role.name for role in model.roles} == {"pour_from", "place_onto"}
    assert [(hold.role, hold.hand) for hold in model.holds] == [("pour_from", "right")]
    (note,) = model.notes
    assert "the left hand holds place," in note
    paired = learn([showing(pouring[0], STEADIED)], settings=replace(LearningSettings(), pairs="all"))
    assert {(hold.role, hold.hand) for hold in paired.holds} == {("pour_from", "right"), ("place", "left")}
    assert paired.notes == ()


@settings(max_examples=10, deadline=None, derandomize=True)
@given(
    names=st.sets(
        st.sampled_from(["apple_juice", "cup_large", "apple_juice_lid", "mug", "kitchen_sideboard"]), min_size=1
    ),
    count=st.integers(1, 2),
    constraint=st.sampled_from(list(CONSTRAINT_TYPES)),
    learning=st.builds(
        LearningSettings,
        time_alignment=st.sampled_from(["events", "phase", "seconds"]),
        pairs=st.sampled_from(["functional", "all"]),
        own_start_pairs=st.booleans(),
        supports=st.sampled_from(["agent", "center"]),
        update_rule=st.sampled_from(["welford", "paper"]),
    ),
)
@example(STEADIED, 1, "cartesian", LearningSettings())
@example(STEADIED, 2, "cylindrical", replace(LearningSettings(), time_alignment="seconds"))
@example({"apple_juice", "mug", "apple_juice_lid"}, 2, "symbolic", LearningSettings.paper())
def test_whatever_is_learned_can_be_read_back(pouring, tmp_path_factory, names, count, constraint, learning):
    path = tmp_path_factory.mktemp("models") / "model.json"
    try:
        model = learn([showing(one, names) for one in (pouring[0], pouring[1])[:count]], constraint, settings=learning)
    except DemonstrationError:
        return
    save_model(model, path)
    assert equal(load_model(path), model)


@pytest.mark.parametrize(
    ("hint", "dtype"),
    [
        (NDArray[np.float64], np.float64),
        (NDArray[np.int64], np.int64),
        (np.ndarray[tuple[int, int], np.dtype[np.int32]], np.int32),
        (ALIAS[np.float64], np.float64),
        (ALIAS[np.int64], np.int64),
        (tuple[float, ...], None),
        (NDArray[np.float64] | None, None),
        (float, None),
        (list[int], None),
    ],
)
def test_arrays_are_recognised_by_their_hints(hint, dtype):
    assert _array_dtype(hint) is dtype


def test_the_file_is_readable(model, tmp_path):
    save_model(model, tmp_path / "model.json")
    lines = (tmp_path / "model.json").read_text().splitlines()
    channels = sum(len(change.channels) for change in model.changes)
    assert sum(line.strip().startswith('"mean": [') for line in lines) == channels
    assert all(line.count("[") <= 1 for line in lines if line.strip().startswith('"mean"'))


def test_hands_that_were_not_seen(model, tmp_path):
    unseen = replace(model, holds=tuple(replace(hold, hand_position=np.zeros((0, 3))) for hold in model.holds))
    save_model(unseen, tmp_path / "model.json")
    assert load_model(tmp_path / "model.json").holds[0].hand_position.shape == (0, 3)


def test_a_later_version_is_refused(content, tmp_path):
    content["format_version"] = 3
    content["something"] = "new"
    with pytest.raises(FileVersionError, match="version 3 is later than 2"):
        load_model(write(tmp_path, content))


def broken(content, path, value):
    *parents, last = path
    for step in parents:
        content = content[step]
    if value is None:
        del content[last]
    else:
        content[last] = value


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (["format"], "other", r"\$\.format: is 'other'.*sbam action model"),
        (["format_version"], None, r"\$\.format_version: is missing"),
        (["format_version"], "1", r"\$\.format_version: is '1'"),
        (["roles"], None, r"\$: .*roles"),
        (["colour"], "red", r"colour.*expected one of.*keypoint_times"),
        (["mode"], "fast", r"\$\.mode: .*default, paper"),
        (["constraint"], "polar", r"\$\.constraint: is 'polar'.*cartesian, cylindrical, symbolic"),
        (["keypoint_times"], [0.0, 2.0, 1.0], r"\$\.keypoint_times: does not increase"),
        (["keypoint_times"], [0.0, "x"], r"\$\.keypoint_times\[1\]: .*float"),
        (
            ["changes", 0, "channels", 0, "mean", 0],
            "high",
            r"\$\.changes\[0\]\.channels\[0\]\.mean\[0\]",
        ),
        (["changes", 0, "channels", 1, "std"], [0.1], r"\$\.changes\[0\]\.channels\[1\]\.std: has 1 numbers"),
        (["changes", 0, "channels", 1, "std", 0], -1.0, r"\$\.changes\[0\]\.channels\[1\]\.std: has a negative"),
        (["changes", 0, "channels", 0, "time", 0], -1.0, r"\$\.changes\[0\]\.channels\[0\]\.time: does not span"),
        (["changes", 1, "channels", 0, "name"], "rho", r"\$\.changes\[1\]\.channels: .*x, y, z"),
        (["changes", 0, "constraint"], "polar", r"\$\.changes\[0\]\.constraint: is 'polar'"),
        (["changes", 0, "pair", "first", "role"], "cup", r"\$\.changes\[0\]\.pair: names 'cup'.*pour_into"),
        (["holds", 0, "role"], "cup", r"\$\.holds\[0\]\.role: is 'cup'"),
        (["holds", 0, "hand"], "middle", r"\$\.holds\[0\]\.hand.*left, right"),
        (["holds", 0, "hand_position", 0], [1.0, 2.0], r"\$\.holds\[0\]\.hand_position.*length 3"),
        (
            ["demonstrations", 0, "candidates", 0, "channels", 0, "value"],
            [1.0],
            r"candidates\[0\]\.channels\[0\]\.value",
        ),
        (["settings", "gap_cost"], "dear", r"\$\.settings\.gap_cost"),
    ],
)
def test_broken_files_say_where(content, tmp_path, path, value, message):
    broken(content, path, value)
    with pytest.raises(FileFormatError, match=message) as caught:
        load_model(write(tmp_path, content))
    assert "changed.json" in str(caught.value)


@pytest.mark.parametrize("text", ["", "{", "[]", "nonsense", '{"format_version": 1, "a": NaN}', "\xff"])
def test_no_json_of_ours(tmp_path, text):
    path = tmp_path / "model.json"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(FileFormatError, match=r"model\.json"):
        load_model(path)


def test_truncated_and_missing_files(model, tmp_path):
    path = tmp_path / "model.json"
    save_model(model, path)
    path.write_text(path.read_text()[: path.stat().st_size // 2])
    with pytest.raises(FileFormatError, match="not valid JSON"):
        load_model(path)
    with pytest.raises(FileFormatError, match="cannot be read"):
        load_model(tmp_path / "absent.json")
    with pytest.raises(OutputError):
        save_model(model, path / "inside a file.json")
