"""SBAM NPZ: what the documentation promises, and clear errors."""

import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sbam.demonstrations.readers import read_demonstration
from sbam.errors import DemonstrationError, FileFormatError, FileVersionError


@pytest.fixture
def arrays(motion) -> dict:
    time, position, angles = motion
    return {
        "format_version": np.array(1),
        "time": time,
        "object_names": np.array(["milk_small", "cup_small"]),
        "position": np.stack([position, position + np.array([0, 300, 0])], axis=1) / 1000,
        "rotation_xyzw": np.stack([Rotation.from_euler("xyz", angles).as_quat()] * 2, axis=1),
    }


@pytest.fixture
def write(tmp_path):
    def write(arrays):
        path = tmp_path / "recording.npz"
        np.savez(path, **arrays)
        return path

    return write


def test_required_arrays_suffice(arrays, write):
    demonstration = read_demonstration(write(arrays))
    assert demonstration.name == "recording"
    assert demonstration.objects == ("milk_small", "cup_small")
    np.testing.assert_allclose(
        demonstration.T_world_object["cup_small"].translation, arrays["position"][:, 1], atol=1e-15
    )
    assert any("no person" in note for note in demonstration.notes)


def test_optional_arrays(arrays, write):
    arrays["hand_names"] = np.array(["right"])
    arrays["hand_position"] = arrays["position"][:, :1] + [0, 0, 0.1]
    arrays["hand_rotation_xyzw"] = arrays["rotation_xyzw"][:, :1]
    arrays["T_world_agent"] = np.eye(4)
    arrays["meta"] = json.dumps(
        {
            "name": "pour 1",
            "synthetic": True,
            "labels": [{"hand": "right", "start": 0.5, "end": 1.0, "action": "Pour", "target": "cup_small"}],
        }
    )
    demonstration = read_demonstration(write(arrays))
    assert (demonstration.name, demonstration.synthetic) == ("pour 1", True)
    assert demonstration.labels[0].action == "Pour"
    assert set(demonstration.T_world_hand) == {"right"}
    np.testing.assert_allclose(demonstration.T_world_agent.as_matrix(), np.eye(4))


def test_nan_is_mended_where_short(arrays, write):
    arrays["position"][10:12, 0] = np.nan
    demonstration = read_demonstration(write(arrays))
    assert np.isfinite(demonstration.T_world_object["milk_small"].as_matrix()).all()
    assert any("frames 10 to 11" in note for note in demonstration.notes)
    arrays["position"][10:30, 0] = np.nan
    with pytest.raises(DemonstrationError, match="too long to interpolate"):
        read_demonstration(write(arrays))
    arrays["position"][:, 0] = np.nan
    with pytest.raises(DemonstrationError, match="milk_small was never seen"):
        read_demonstration(write(arrays))


@pytest.mark.parametrize("key", ["time", "object_names", "position", "rotation_xyzw", "format_version"])
def test_missing_array(arrays, write, key):
    del arrays[key]
    with pytest.raises(FileFormatError, match=f"{key}.* is missing"):
        read_demonstration(write(arrays))


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("position", np.zeros((41, 3)), r"position: is float64 of shape \(41, 3\) .*\(41, 2, 3\)"),
        ("rotation_xyzw", np.full((41, 2, 4), 0.7), "frame 0: quaternion has length 1.4"),
        ("object_names", np.array(["a", "a"]), "occurs twice"),
        ("object_names", np.array([1, 2]), "a list of text"),
        ("object_names", np.array(["a", "b"], dtype=object), "without pickle"),
        ("time", np.zeros(41), "does not come after"),
        ("hand_names", np.array(["left"]), "hand_position: is missing"),
        ("T_world_agent", 2 * np.eye(4), "no gravity-aligned pose"),
        ("meta", np.array("{"), "meta"),
        ("meta", np.array('{"unknown": 1}'), "unknown"),
        ("format_version", np.array("one"), "no integer"),
    ],
)
def test_bad_array(arrays, write, key, value, message):
    arrays[key] = value
    with pytest.raises(FileFormatError, match=message):
        read_demonstration(write(arrays))


def test_later_version(arrays, write):
    arrays["format_version"] = np.array(2)
    with pytest.raises(FileVersionError, match="format version 2 is later than 1"):
        read_demonstration(write(arrays))


def test_millimetres(arrays, write):
    arrays["position"] *= 1000
    with pytest.raises(FileFormatError, match="are these millimetres"):
        read_demonstration(write(arrays))


def test_truncated(arrays, write):
    path = write(arrays)
    path.write_bytes(path.read_bytes()[:700])
    with pytest.raises(FileFormatError, match="not a readable NPZ file"):
        read_demonstration(path)
