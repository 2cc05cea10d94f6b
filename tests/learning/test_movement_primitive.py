"""Via-point movement primitives."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from sbam.demonstrations.synthetic import built_in_demonstrations
from sbam.learning.learn import learn
from sbam.learning.model_file import load_model, save_model
from sbam.learning.movement_primitive import learn_primitive, sketch_path

TIME = np.linspace(1.0, 4.0, 151)


def swings(count: int, seed: int = 0) -> list[np.ndarray]:
    """Paths that swing out and back, by different amounts, from different places."""
    generator = np.random.default_rng(seed)
    phase = (TIME - TIME[0]) / np.ptp(TIME)
    shape = np.stack([np.sin(np.pi * phase) ** 2, 0.3 * np.sin(2 * np.pi * phase)], axis=1)
    return [generator.normal(0, 0.3, 2) + generator.uniform(0.7, 1.3) * shape for _ in range(count)]


@given(seed=st.integers(0, 1000), count=st.integers(2, 12))
@settings(max_examples=25, deadline=None)
def test_it_goes_through_its_via_points(seed, count):
    primitive = learn_primitive(TIME, swings(5), spread=0.02)
    generator = np.random.default_rng(seed)
    via_time = np.concatenate([[TIME[0]], np.sort(generator.choice(TIME[3:-3:4], count, replace=False)), [TIME[-1]]])
    via = generator.normal(0, 0.5, (len(via_time), 2))
    np.testing.assert_allclose(primitive.through(via_time, via, via_time), via, atol=1e-9)


def test_without_via_points_it_keeps_the_mean_shape():
    """Between two ends alone it is the mean of the demonstrated shapes, carried to the ends."""
    paths = swings(6)
    primitive = learn_primitive(TIME, paths, spread=0.02)
    ends = np.array([[5.0, 1.0], [6.0, 1.0]])
    mean = np.mean([path - path[0] for path in paths], axis=0)
    expected = ends[0] + np.linspace(0, 1, len(TIME))[:, None] * (ends[1] - ends[0]) + mean
    np.testing.assert_allclose(primitive.through(TIME[[0, -1]], ends, TIME), expected, atol=0.01)


def test_one_via_point_tells_how_large_the_swing_is():
    """Demonstrations differ in size alone: a point in the middle decides about the whole path."""
    primitive = learn_primitive(TIME, swings(8), spread=1e-3)
    paths = swings(1, seed=5)
    larger = paths[0][0] + 1.5 * (paths[0] - paths[0][0])
    at = [0, 75, 150]
    found = primitive.through(TIME[at], larger[at], TIME)[:, 0]
    straight = np.interp(TIME, TIME[at], larger[at, 0])
    assert np.abs(found - larger[:, 0]).max() < 0.25 * np.abs(straight - larger[:, 0]).max()


def test_a_path_is_sketched_as_it_was():
    demonstration = built_in_demonstrations("rolling")[0]
    path = sketch_path(demonstration, "rolling_pin", "handle_left")
    time = demonstration.time - demonstration.time[0]
    position, rotation = path.at(time, float(time[-1]))
    pose = demonstration.T_world_agent.inv() * demonstration.T_world_object["rolling_pin"]
    assert np.linalg.norm(position - pose.translation, axis=1).mean() < 1e-3
    turned = pose.rotation * pose.rotation[0].inv()
    assert np.rad2deg((rotation.inv() * turned).magnitude()).mean() < 1.0


def test_turns_beyond_half_a_turn_do_not_jump():
    demonstration = built_in_demonstrations("rolling")[0]
    name = "rolling_pin"
    angle = np.linspace(0, 3 * np.pi, len(demonstration.time))
    pose = demonstration.T_world_object[name]
    spun = type(pose).from_components(
        pose.translation, Rotation.from_rotvec(angle[:, None] * [1, 0, 0]) * pose.rotation[0]
    )
    turning = replace(demonstration, T_world_object={**demonstration.T_world_object, name: spun})
    rotation = sketch_path(turning, name, "handle_left").rotation
    assert np.linalg.norm(np.diff(rotation, axis=0), axis=1).max() < 0.5
    assert np.linalg.norm(rotation[-1]) == pytest.approx(3 * np.pi, abs=0.1)


def test_models_keep_paths_in_their_files(tmp_path):
    model = learn(built_in_demonstrations("rolling")[:2])
    assert [path.role for sketch in model.demonstrations for path in sketch.paths] == ["handle_left", "handle_left"]
    save_model(model, tmp_path / "model.json")
    again = load_model(tmp_path / "model.json")
    for before, after in zip(model.demonstrations, again.demonstrations, strict=True):
        np.testing.assert_array_equal(before.paths[0].position, after.paths[0].position)
        np.testing.assert_array_equal(before.paths[0].rotation, after.paths[0].rotation)


def test_models_of_earlier_versions_have_none(tmp_path):
    model = learn(built_in_demonstrations("rolling")[:2])
    path = tmp_path / "model.json"
    save_model(model, path)
    content = json.loads(path.read_text())
    for sketch in content["demonstrations"]:
        del sketch["paths"]
    path.write_text(json.dumps(content))
    assert all(sketch.paths == () for sketch in load_model(path).demonstrations)
