"""Reading one object file: the normal path is the library's; here is what can be wrong with it."""

import copy

import numpy as np
import pytest
import yaml

from sbam.errors import FileFormatError, FileVersionError
from sbam.scene import load_object

GOOD = {
    "format_version": 1,
    "name": "block",
    "up": [0, 0, 1],
    "movable": True,
    "mass": 0.1,
    "affordance_regions": [
        {"affordance": "place", "center": [0, 0, -0.02], "half_axes": [0.02, 0.01], "normal": [0, 0, -1]},
        {"affordance": "place onto", "center": [0, 0, 0.02], "half_axes": [0.02, 0.01], "normal": [0, 0.6004, 0.8]},
    ],
    "geometry": [
        {"kind": "box", "size": [0.04, 0.02, 0.04], "rotation_rpy_deg": [0, 0, 90]},
        {"kind": "cylinder", "radius": 0.01, "length": 0.1, "axis": [0, -1, 0], "center": [1, 2, 3]},
        {"kind": "capsule", "radius": 0.01, "length": 0.1, "axis": [0, 0, -1], "rgba": [1, 0, 0, 0.5]},
        {"kind": "sphere", "radius": 0.01},
    ],
    "grasp_regions": [
        {"name": "body", "kind": "around", "center": [0, 0, 0], "axis": [0, 0, 1], "half_length": 0.01, "width": 0.02}
    ],
}


def write(tmp_path, content) -> str:
    path = tmp_path / "block.yaml"
    path.write_text(content if isinstance(content, str) else yaml.safe_dump(content))
    return str(path)


def changed(*steps, value) -> dict:
    """A good file with one value changed, or removed where ``value`` is ``...``."""
    content = copy.deepcopy(GOOD)
    part = content
    for step in steps[:-1]:
        part = part[step]
    if value is ...:
        del part[steps[-1]]
    else:
        part[steps[-1]] = value
    return content


def test_sizes_axes_and_colours_mean_what_the_documentation_says(tmp_path) -> None:
    model = load_object(write(tmp_path, GOOD))
    box, cylinder, capsule, sphere = model.geometry
    np.testing.assert_allclose(box.size, [0.02, 0.01, 0.02])
    np.testing.assert_allclose(box.T_object_primitive.apply([1, 0, 0]), [0, 1, 0], atol=1e-12)
    np.testing.assert_allclose(cylinder.size, [0.01, 0.05])
    np.testing.assert_allclose(cylinder.T_object_primitive.apply([0, 0, 1]), [1, 1, 3], atol=1e-12)
    np.testing.assert_allclose(capsule.T_object_primitive.rotation.apply([0, 0, 1]), [0, 0, -1], atol=1e-12)
    np.testing.assert_allclose(capsule.rgba, [1, 0, 0, 0.5])
    assert (sphere.kind, sphere.size.tolist(), sphere.rgba[3]) == ("sphere", [0.01], 1.0)
    assert np.isclose(np.linalg.norm(model.region("place onto").normal), 1, atol=1e-12), "normalised"


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (
            changed("affordance_regions", 0, "center", 2, value="low"),
            r"\$\.affordance_regions\[0\]\.center\[2\].*flo",
        ),
        (changed("affordance_regions", 0, "center", value=[0, 0]), r"\$\.affordance_regions\[0\]\.center.*length 3"),
        (changed("affordance_regions", 1, "centre", value=[0, 0, 0]), r"affordance_regions\[1\].*`centre`.*half_axes"),
        (changed("affordance_regions", 1, "affordance", value="place"), r"\[1\]\.affordance.*given twice"),
        (
            changed("affordance_regions", 0, "half_axes", 1, value=0),
            r"half_axes\[1\]: is 0 \(expected a number above",
        ),
        (changed("affordance_regions", 0, "normal", value=[0, 0, 2]), r"normal: has length 2 \(expected a unit vector"),
        (changed("affordance_regions", 0, "center", 0, value=float("nan")), r"center\[0\]: is nan .*finite"),
        (changed("geometry", 0, "kind", value="cube"), r"\$\.geometry\[0\]\.kind.*cube.*box, .*sphere"),
        (changed("geometry", 1, "length", value=...), r"\$\.geometry\[1\].*missing required field `length`"),
        (changed("geometry", 1, "size", value=1), r"\$\.geometry\[1\].*`size`.*kind, radius, length, axis"),
        (changed("geometry", 3, "radius", value=-1), r"\$\.geometry\[3\]\.radius: is -1"),
        (changed("geometry", 2, "rgba", value=[255, 0, 0]), r"\$\.geometry\[2\]\.rgba\[0\]: is 255 \(expected 0 to 1"),
        (changed("geometry", 2, "rgba", value=[1, 0]), r"\$\.geometry\[2\]\.rgba.*length"),
        (changed("grasp_regions", 0, "kind", value="over"), r"\$\.grasp_regions\[0\]\.kind.*across, around"),
        (changed("grasp_regions", 0, "faces", value=2), r"faces: is 2"),
        (changed("up", value=[0, 0, 0]), r"\$\.up: has length 0"),
        (changed("mass", value=True), r"\$\.mass.*float"),
        (changed("name", value=" "), r"\$\.name: is empty"),
        (changed("weight", value=1), r"`weight`.*expected one of format_version, name, up"),
        (changed("format_version", value=...), r"missing required field `format_version`"),
        (changed("format_version", value=0), r"\$\.format_version: is 0 \(expected 1 to 1"),
        ("", r"\$: holds no fields"),
        ("- 1", r"\$: holds no fields"),
    ],
)
def test_what_is_wrong_is_said_with_its_place(tmp_path, content, says) -> None:
    path = write(tmp_path, content)
    with pytest.raises(FileFormatError, match=says) as error:
        load_object(path)
    assert str(error.value).startswith(path)


def test_a_later_version_is_refused_whatever_else_it_holds(tmp_path) -> None:
    with pytest.raises(FileVersionError, match="format version 2 is later than 1"):
        load_object(write(tmp_path, {"format_version": 2, "colour of magic": "octarine"}))
