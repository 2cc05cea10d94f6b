"""KIT CSV: columns in any order, labels in between, and clear errors."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sbam.demonstrations.demonstration import Label
from sbam.demonstrations.readers import read_demonstration
from sbam.errors import DemonstrationError, FileFormatError

QUATERNION = ("qw", "qx", "qy", "qz")


def test_millimetres_quaternions_and_labels_in_between(write_csv, motion):
    time, position, angles = motion
    demonstration = read_demonstration(write_csv())
    np.testing.assert_allclose(demonstration.time, time)
    T = demonstration.T_world_object["milk_small"]
    np.testing.assert_allclose(T.translation, position / 1000)
    assert (T.rotation * Rotation.from_euler("xyz", angles).inv()).magnitude().max() < 1e-12
    assert "ignored columns: comment" in demonstration.notes
    assert not demonstration.synthetic


def test_hands(write_csv, motion):
    def add_hand(columns):
        columns |= {f"left_hand[{axis}]": columns[f"milk_small[{axis}]"] for axis in ("x", "y", "z")}
        columns |= {f"left_hand[{axis}]": [value] * 41 for axis, value in zip(QUATERNION, (1, 0, 0, 0), strict=True)}

    demonstration = read_demonstration(write_csv(add_hand))
    assert demonstration.objects == ("milk_small",)
    np.testing.assert_allclose(demonstration.T_world_hand["left"].translation, motion[1] / 1000)


def test_label_columns(write_csv):
    def add_labels(columns):
        columns["right_hand_label"] = [""] * 10 + ["Pour:cup"] * 20 + ["Place"] * 11

    assert read_demonstration(write_csv(add_labels)).labels == (
        Label("right", 1.0, 3.0, "Pour", "cup"),
        Label("right", 3.0, 4.0, "Place"),
    )


def test_windows_line_ends_and_byte_order_mark(write_csv):
    path = write_csv()
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes().replace(b"\n", b"\r\n"))
    assert read_demonstration(path).objects == ("milk_small",)


def test_empty_cells_are_missing_poses(write_csv):
    def lose(columns):
        columns["milk_small[y]"][7] = float("nan")

    demonstration = read_demonstration(write_csv(lose))
    assert any("frame 7 (0.70 to 0.70 s) of milk_small is missing" in note for note in demonstration.notes)


def drop(column):
    return lambda columns: columns.pop(column)


def put(column, row, value):
    return lambda columns: columns[column].__setitem__(row, value)


def scale(axes, factor):
    def change(columns):
        for axis in axes:
            columns[f"milk_small[{axis}]"] = [factor * value for value in columns[f"milk_small[{axis}]"]]

    return change


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (drop("timestep"), r"column 'timestep' is missing \(columns: milk_small\[x\]"),
        (drop("milk_small[qz]"), r"missing milk_small\[qz\] \(columns: timestep, milk_small\[x\]"),
        (put("milk_small[x]", 3, "left"), r"line 5, column 'milk_small\[x\]': 'left'"),
        (put("timestep", 3, 0.2), "frame 3: time stamp 0.2 s does not come after 0.2 s"),
        (put("timestep", 3, ""), "time stamp is not a number"),
        (put("milk_small[qw]", 3, 0.1), "frame 3: quaternion has length"),
        (scale(("qw", "qx", "qy", "qz"), 2), "frame 0: quaternion has length 2"),
        (scale("xyz", 1e-3), "are these metres"),
        (scale("xyz", 1e3), "m apart"),
        (lambda columns: [columns.pop(c) for c in list(columns) if c != "timestep"], "no object"),
    ],
)
def test_bad_columns(write_csv, change, message):
    with pytest.raises(FileFormatError, match=message):
        read_demonstration(write_csv(change))


def test_bad_text(write_csv):
    path = write_csv()
    text = path.read_text()
    path.write_text(text[: text.rindex(",", 0, len(text) // 2)])
    with pytest.raises(FileFormatError, match=r"line \d+: \d values .*expected 9"):
        read_demonstration(path)
    path.write_text(text.splitlines()[0])
    with pytest.raises(FileFormatError, match="no frame"):
        read_demonstration(path)
    path.write_text("\n".join(text.splitlines()[:2]))
    with pytest.raises(DemonstrationError, match="one frame only"):
        read_demonstration(path)
    path.write_bytes(text.encode("utf-16"))
    with pytest.raises(FileFormatError, match="UTF-8"):
        read_demonstration(path)
    path.write_text(text.replace("milk_small[y]", "milk_small[x]", 1))
    with pytest.raises(FileFormatError, match="occurs twice"):
        read_demonstration(path)
