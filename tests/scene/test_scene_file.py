"""Reading and writing scene files."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.errors import FileFormatError, FileVersionError, UnknownNameError
from sbam.scene import ObjectLibrary, Scene, agent_pose, load_scene, region_centers, save_scene, support_height

EXAMPLES = Path(__file__).parents[2] / "src" / "sbam" / "scene" / "scenes"

CUP = {"position": [0.4, 0.1, 0.9], "upright_yaw_deg": 0}


def write(tmp_path, **content) -> Path:
    path = tmp_path / "kitchen.yaml"
    path.write_text(yaml.safe_dump({"format_version": 1, **content}, sort_keys=False))
    return path


def test_all_ways_to_say_a_rotation_mean_the_same(tmp_path) -> None:
    rotation = Rotation.from_euler("z", 30, degrees=True) * Rotation.from_euler("x", 90, degrees=True)
    ways = [
        {"upright_yaw_deg": 30},
        {"rotation_rpy_deg": [90, 0, 30]},
        {"rotation_xyzw": rotation.as_quat().round(5).tolist()},
        {"rotation_wxyz": rotation.as_quat(scalar_first=True).round(5).tolist()},
    ]
    objects = {f"cup {i}": {"model": "cup_small", "position": [i, 0, 0], **way} for i, way in enumerate(ways)}
    scene = load_scene(write(tmp_path, objects=objects, agent={"position": [0, 0, 0], "heading_deg": 0}))
    for name in objects:
        assert scene.objects[name].name == "cup_small"
        assert (scene.T_world_object[name].rotation * rotation.inv()).magnitude() < 1e-4


def test_without_an_agent_it_stands_at_the_table_before_the_objects(tmp_path) -> None:
    objects = {
        "kitchen_sideboard": {"position": [0.9, 0, 0.856], "upright_yaw_deg": 90},
        "cup_small": {"position": [0.5, 0.1, 0.88], "upright_yaw_deg": 0},
        "milk_small": {"position": [0.7, -0.3, 0.88], "upright_yaw_deg": 0},
    }
    scene = load_scene(write(tmp_path, objects=objects))
    np.testing.assert_allclose(scene.T_world_agent.translation, [0.15, -0.1, 0.88])
    np.testing.assert_allclose(scene.T_world_agent.rotation.apply([0, 1, 0]), [1, 0, 0], atol=1e-12)
    assert (scene.name, scene.robot) == ("kitchen", None)


number = st.floats(-2.5, 2.5, allow_subnormal=False)
quaternion = st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1)


@settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.tuples(number, number, number), quaternion, st.floats(-180, 180), st.sampled_from([None, "panda_dual"]))
def test_a_saved_scene_comes_back(tmp_path, position, xyzw, heading, robot) -> None:
    library = ObjectLibrary.built_in()
    pose = RigidTransform.from_components(np.array(position), Rotation.from_quat(xyzw))
    scene = Scene(
        name="Küche: 'no', 1",
        objects={"cup_small": library["cup_small"], "second cup": library["cup_small"], "bottle": library["bottle"]},
        T_world_object={"cup_small": pose, "second cup": pose.inv(), "bottle": RigidTransform.identity()},
        T_world_agent=agent_pose(position, heading),
        robot=robot,
    )
    save_scene(scene, tmp_path / "scene.yaml")
    back = load_scene(tmp_path / "scene.yaml")
    assert (back.name, back.robot, list(back.objects)) == (scene.name, scene.robot, list(scene.objects))
    for name, model in scene.objects.items():
        assert back.objects[name] is model
        difference = back.T_world_object[name].as_matrix() - scene.T_world_object[name].as_matrix()
        assert np.abs(difference).max() < 1e-12
    assert np.abs(back.T_world_agent.as_matrix() - scene.T_world_agent.as_matrix()).max() < 1e-12


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ({"objects": {}}, r"\$\.objects: is empty"),
        ({"name": "x"}, "missing required field `objects`"),
        ({"objects": [CUP]}, r"\$\.objects: expected `object`, got `array`"),
        ({"objects": {"mug": CUP}, "robots": "panda"}, r"`robots`.*one of format_version, objects, name, robot, agent"),
        ({"objects": {"mug": {"position": [0, 0, 0]}}}, r"\$\.objects\.mug: does not say its rotation.*exactly one of"),
        ({"objects": {"mug": {**CUP, "rotation_rpy_deg": [0, 0, 0]}}}, r"says its rotation 2 times \(rotation_rpy_deg"),
        ({"objects": {"mug": {**CUP, "position": [0, 0]}}}, r"\$\.objects\.mug\.position: .*length 3"),
        ({"objects": {"mug": {**CUP, "position": [0, 0, "up"]}}}, r"\$\.objects\.mug\.position\[2\]"),
        ({"objects": {"mug": {**CUP, "yaw": 3}}}, r"\$\.objects\.mug: .*`yaw`.*upright_yaw_deg"),
        ({"objects": {"mug": {**CUP, "position": [0, 0, float("nan")]}}}, r"\$\.objects\.mug\.position\[2\]: is nan"),
        (
            {"objects": {"mug": {"position": [0, 0, 0], "rotation_xyzw": [0, 0, 0, 0]}}},
            r"\$\.objects\.mug\.rotation_xyzw: has length 0 \(expected a unit quaternion",
        ),
        (
            {"objects": {"mug": {"position": [0, 0, 0], "rotation_wxyz": [1, 1, 0, 0]}}},
            r"rotation_wxyz: has length 1\.414",
        ),
        ({"objects": {"mug": {**CUP, "position": [450, 80, 0]}}}, r"mug\.position: holds 450.*mm \(expected metres"),
        (
            {"objects": {"mug": {**CUP, "position": [8, 0, 0]}, "bottle": {**CUP, "position": [-8, 0, 0]}}},
            r"\$\.objects\.mug\.position: lies 16 m from \$\.objects\.bottle\.position.*mm \(expected metres",
        ),
        (
            {"objects": {"mug": CUP}, "agent": {"position": [0, 900, 0], "heading_deg": 0}},
            r"\$\.agent\.position: holds 900.*mm",
        ),
        ({"objects": {"mug": CUP}, "agent": {"position": [0, 0, 0]}}, r"\$\.agent.*`heading_deg`"),
    ],
)
def test_what_is_wrong_is_said_with_its_place(tmp_path, content, says) -> None:
    path = write(tmp_path, **content)
    with pytest.raises(FileFormatError, match=says) as error:
        load_scene(path)
    assert str(error.value).startswith(str(path))


def test_an_unknown_model_lists_the_known_ones(tmp_path) -> None:
    path = write(tmp_path, objects={"cup": CUP})
    with pytest.raises(UnknownNameError, match=r"'cup' in .*kitchen\.yaml at \$\.objects\.cup; known: 'apple_juice'"):
        load_scene(path)


def test_a_later_version_is_refused(tmp_path) -> None:
    with pytest.raises(FileVersionError, match="format version 7"):
        load_scene(write(tmp_path, format_version=7))


def test_an_agent_that_is_not_upright_is_not_saved(tmp_path) -> None:
    library = ObjectLibrary.built_in()
    tilted = RigidTransform.from_rotation(Rotation.from_euler("x", 0.1))
    scene = Scene("x", {"mug": library["mug"]}, {"mug": tilted}, tilted)
    with pytest.raises(ValueError, match="gravity-aligned"):
        save_scene(scene, tmp_path / "scene.yaml")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.yaml")), ids=lambda path: path.stem)
def test_the_example_scenes_stand_on_their_table_within_reach(path: Path) -> None:
    scene = load_scene(path)
    assert np.isclose(support_height(scene), 0.0)
    for name, bottom in region_centers(scene, "place").items():
        assert np.isclose(bottom[2], 0.0), name
    for name, model in scene.objects.items():
        if model.movable:
            in_agent = scene.T_world_agent.inv().apply(scene.T_world_object[name].translation)
            assert 0.25 < in_agent[1] < 0.60
            assert abs(in_agent[0]) < 0.30
    assert scene.robot == "panda_dual"


def test_there_are_example_scenes_and_the_new_layout_is_new() -> None:
    assert len(list(EXAMPLES.glob("*.yaml"))) >= 3
    scene = load_scene(EXAMPLES / "pouring_new_layout.yaml")
    to_agent = scene.T_world_agent.inv()
    cup, bottle = (to_agent.apply(scene.T_world_object[name].translation) for name in ("cup_large", "apple_juice"))
    demonstrated = [(0.20, 0), (0.40, 45), (0.30, 180)]
    for distance, angle in demonstrated:
        layout = distance * np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
        assert np.linalg.norm((bottle - cup)[:2] - layout) > 0.05


def test_the_rolling_scene_has_the_left_handle_at_the_agent_s_left() -> None:
    scene = load_scene(EXAMPLES / "rolling.yaml")
    handle = region_centers(scene, "handle left")["rolling_pin"]
    assert scene.T_world_agent.inv().apply(handle)[0] < -0.15
