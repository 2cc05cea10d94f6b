"""The built-in objects and folders of own objects."""

import numpy as np
import pytest

from sbam.errors import FileFormatError, UnknownNameError
from sbam.scene import ObjectLibrary, ObjectModel

BUILT_IN = (
    "apple_juice",
    "apple_juice_lid",
    "bottle",
    "cup_large",
    "cup_small",
    "kitchen_sideboard",
    "milk_small",
    "mug",
    "rolling_pin",
    "tablespoon",
)

RESTING = ("apple_juice", "cup_large", "cup_small", "kitchen_sideboard", "milk_small", "rolling_pin")
"""Objects that rest on their lowest region in the real recordings; the spoon leans, the lid lies upside down."""

BLOCK = """
format_version: 1
name: {name}
up: [0, 0, 1]
movable: true
mass: 0.1
affordance_regions:
  - {{affordance: place, center: [0, 0, -0.02], half_axes: [0.02, 0.02], normal: [0, 0, -1]}}
geometry:
  - {{kind: box, size: [0.04, 0.04, 0.04]}}
"""


@pytest.fixture(scope="module")
def library() -> ObjectLibrary:
    return ObjectLibrary.built_in()


def extent_along_up(model: ObjectModel) -> tuple[float, float]:
    """Lowest and highest point of the geometry along the object's up axis, from its corners or round ends."""
    ends = []
    for part in model.geometry:
        axes = part.T_object_primitive.rotation.as_matrix()
        up = np.abs(model.up @ axes)
        if part.kind == "box":
            reach = float(up @ part.size)
        else:
            reach = float(up[2] * part.size[1] + np.sqrt(max(0.0, 1 - up[2] ** 2)) * part.size[0])
        height = float(model.up @ part.T_object_primitive.translation)
        ends += [height - reach, height + reach]
    return min(ends), max(ends)


def test_the_library_holds_the_objects_of_the_recordings(library: ObjectLibrary) -> None:
    assert library.names == BUILT_IN
    assert tuple(library) == BUILT_IN
    assert len(library) == len(BUILT_IN)
    assert all(library[name].name == name for name in BUILT_IN)


@pytest.mark.parametrize("name", BUILT_IN)
def test_every_object_is_sound(library: ObjectLibrary, name: str) -> None:
    model = library[name]
    assert model.geometry
    assert model.mass > 0
    assert np.isclose(np.linalg.norm(model.up), 1)
    for region in model.affordance_regions:
        assert np.isclose(np.linalg.norm(region.normal), 1)
        assert (region.half_axes > 0).all()


@pytest.mark.parametrize("name", ["apple_juice", "bottle", "cup_large", "cup_small", "milk_small", "mug"])
def test_a_vessel_stands_on_its_place_region_and_its_mouth_is_its_top(library: ObjectLibrary, name: str) -> None:
    model = library[name]
    bottom, top = extent_along_up(model)
    place = model.region("place")
    mouth = model.region("pour into" if "pour into" in model.affordances else "pour from")
    assert np.isclose(place.center @ model.up, bottom)
    assert np.isclose(mouth.center @ model.up, top)
    np.testing.assert_allclose(place.normal, -model.up)
    np.testing.assert_allclose(mouth.normal, model.up)


@pytest.mark.parametrize("name", [name for name in BUILT_IN if name != "kitchen_sideboard"])
def test_grasps_lie_within_the_object_and_fit_a_panda_gripper(library: ObjectLibrary, name: str) -> None:
    model = library[name]
    assert model.grasp_regions
    for grasp in model.grasp_regions:
        assert grasp.width < 0.080
        for end in (-1, 1):
            point = grasp.center + end * grasp.half_length * grasp.axis
            inside = [
                np.abs(part.T_object_primitive.inv().apply(point)[2]) <= part.size[-1] + 1e-9
                for part in model.geometry
                if part.kind != "box"
            ] + [
                bool((np.abs(part.T_object_primitive.inv().apply(point)) <= part.size + 1e-9).all())
                for part in model.geometry
                if part.kind == "box"
            ]
            assert any(inside)


def test_the_table_s_surface_is_the_top_of_its_geometry(library: ObjectLibrary) -> None:
    table = library["kitchen_sideboard"]
    assert not table.movable
    assert np.isclose(table.region("place onto").center @ table.up, extent_along_up(table)[1])


def test_the_handles_of_the_pin_lie_opposite(library: ObjectLibrary) -> None:
    pin = library["rolling_pin"]
    np.testing.assert_allclose(pin.region("handle left").center, -pin.region("handle right").center)
    assert [grasp.name for grasp in pin.grasp_regions] == ["handle left", "handle right"]


def test_an_unknown_object_lists_the_known_ones(library: ObjectLibrary) -> None:
    with pytest.raises(UnknownNameError, match=r"'teapot'.*'cup_small'"):
        library["teapot"]
    assert "teapot" not in library


def test_own_objects_are_added_and_replace_built_in_ones(library: ObjectLibrary, tmp_path) -> None:
    (tmp_path / "block.yaml").write_text(BLOCK.format(name="block"))
    (tmp_path / "mug.yml").write_text(BLOCK.format(name="mug"))
    (tmp_path / "notes.txt").write_text("not an object")
    own = library.with_folder(tmp_path)
    assert set(own.names) == {*BUILT_IN, "block"}
    assert own["mug"].affordances == ("place",)
    assert library["mug"].affordances == ("place", "pour into"), "the first library has not changed"


def test_two_files_with_one_name_are_refused(library: ObjectLibrary, tmp_path) -> None:
    (tmp_path / "a.yaml").write_text(BLOCK.format(name="block"))
    (tmp_path / "b.yaml").write_text(BLOCK.format(name="block"))
    with pytest.raises(FileFormatError, match=r"b\.yaml at \$\.name.*a\.yaml"):
        library.with_folder(tmp_path)


def test_a_folder_without_objects_is_refused(library: ObjectLibrary, tmp_path) -> None:
    with pytest.raises(FileFormatError, match="holds no object files"):
        library.with_folder(tmp_path)
    with pytest.raises(FileFormatError, match="is not a folder"):
        library.with_folder(tmp_path / "absent")


def test_resting_heights_of_the_recordings_fit_the_table(library: ObjectLibrary, recordings_folder) -> None:
    """The table top lies within 5 mm of the bottoms of what rests on it in the real recordings."""
    import defusedxml.ElementTree as ElementTree
    from scipy.spatial.transform import RigidTransform, Rotation

    offsets = []
    for path in sorted((recordings_folder / "kit_bimanual").glob("*_files_motions_*.xml")):
        poses = {}
        for motion in ElementTree.parse(path).getroot().iter("Motion"):
            for sensor in motion.iter("Sensor"):
                if sensor.get("type") == "ModelPose" and motion.get("name") in RESTING:
                    first = next(sensor.iter("Measurement"))
                    position = np.array(first.findtext("RootPosition", "").split(), dtype=float) / 1000
                    angles = np.array(first.findtext("RootRotation", "").split(), dtype=float)
                    rotation = Rotation.from_euler("xyz", angles)
                    poses[motion.get("name")] = RigidTransform.from_components(position, rotation)
        table = poses.pop("kitchen_sideboard")
        top = library["kitchen_sideboard"].region("place onto")
        for name, pose in poses.items():
            model = library[name]
            radius = model.geometry[0].size[0] if name == "rolling_pin" else 0.0
            bottom = pose.translation - np.array([0, 0, radius])
            offsets.append((table.inv().apply(bottom) - top.center) @ top.normal)
    assert len(offsets) >= 5
    assert np.abs(offsets).max() < 0.005
    assert abs(np.mean(offsets)) < 0.002
