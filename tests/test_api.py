"""The public names on one screen."""

import ast
import inspect
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import sbam
from sbam.demonstrations.scenes import starting_scene
from sbam.errors import DemonstrationError, SbamError, UnknownNameError

SOURCE = Path(sbam.__file__)


def test_type_checkers_see_the_same_names_as_programs() -> None:
    block = next(node for node in ast.parse(SOURCE.read_text()).body if isinstance(node, ast.If))
    declared = {
        alias.asname or alias.name: (node.module, alias.name)
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    at_run_time = {}
    for name, home in sbam._HOME.items():
        module, _, original = home.partition(":")
        at_run_time[name] = (module, original or name)
    assert declared == at_run_time
    assert sorted(declared) == sorted(sbam.__all__)


@pytest.mark.parametrize("name", sbam.__all__)
def test_every_name_is_there_and_documented(name: str) -> None:
    thing = getattr(sbam, name)
    assert callable(thing)
    assert inspect.getdoc(thing)
    assert name in dir(sbam)


def test_it_fits_on_one_screen_and_other_names_are_unknown() -> None:
    assert len(sbam.__all__) <= 30
    with pytest.raises(AttributeError, match="no attribute 'fly'"):
        sbam.fly  # noqa: B018


def test_functions_are_not_hidden_by_modules_of_a_like_name() -> None:
    code = (
        "import sbam, sbam.planning.plan, sbam.learning.learn\n"
        "assert callable(sbam.plan) and callable(sbam.learn)\n"
        "from sbam import plan, learn\n"
        "assert plan is sbam.plan and learn is sbam.learn\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_from_recordings_to_a_trajectory(tmp_path: Path) -> None:
    demonstrations = sbam.load("built-in:pouring")
    model = sbam.learn(demonstrations[:3])
    model = sbam.add_demonstration(model, demonstrations[3])
    sbam.save_model(model, tmp_path / "model.json")
    scene = sbam.load_scene("built-in:pouring_new_layout")
    plan = sbam.plan(sbam.load_model(tmp_path / "model.json"), scene, sbam.load_robot("panda_dual"))
    assert isinstance(plan, sbam.Plan) and plan.ok
    trajectory = plan.trajectory
    assert isinstance(trajectory, sbam.JointTrajectory)
    assert trajectory.position.shape == (len(trajectory.time), len(trajectory.joint_names))
    files = sbam.write_plan(plan, tmp_path / "out")
    assert {"trajectory.npz", "trajectory.csv"} <= {file.name for file in files}


def test_load_takes_files_folders_and_built_in_ones(tmp_path: Path) -> None:
    first, second = sbam.built_in_demonstrations("rolling")[:2]
    sbam.write_demonstration(first, tmp_path / "folder" / f"{first.name}.npz")
    sbam.write_demonstration(second, tmp_path / f"{second.name}.xml")
    seen = []
    loaded = sbam.load(
        [tmp_path / "folder", str(tmp_path / f"{second.name}.xml"), "built-in:synthetic_rolling_2"],
        lambda done, total: seen.append((done, total)),
    )
    assert [one.name for one in loaded] == [first.name, second.name, "synthetic_rolling_2"]
    assert seen == [(1, 3), (2, 3), (3, 3)]
    assert np.allclose(loaded[0].time, first.time)
    with pytest.raises(DemonstrationError, match=f"{first.name}.*is in both"):
        sbam.load([tmp_path / "folder", f"built-in:{first.name}"])
    with pytest.raises(UnknownNameError, match="'rolling'"):
        sbam.load("built-in:flying")


def test_the_scene_of_a_demonstration_is_its_first_frame() -> None:
    (demonstration,) = sbam.load("built-in:synthetic_pouring_milk_right_9")
    scene = sbam.scene_from_demonstration(demonstration)
    assert set(scene.objects) == set(demonstration.objects)
    for name, poses in demonstration.T_world_object.items():
        assert np.array_equal(scene.T_world_object[name].as_matrix(), poses[0].as_matrix())
    assert starting_scene("built-in:synthetic_pouring_milk_right_9").name == scene.name
    with pytest.raises(DemonstrationError, match="several recordings"):
        sbam.load_scene("built-in:pouring")
    with pytest.raises(UnknownNameError, match=r"'pouring_milk'.*'rolling', 'pouring'"):
        sbam.load_scene("built-in:flying")


def test_unknown_objects_are_left_out_of_a_scene_only_if_they_never_move() -> None:
    (demonstration,) = sbam.load("built-in:synthetic_pouring_milk_right_9")
    models = {name: sbam.ObjectLibrary.built_in()[name] for name in ("cup_small", "milk_small")}
    assert set(sbam.scene_from_demonstration(demonstration, sbam.ObjectLibrary(models)).objects) == set(models)
    del models["milk_small"]
    with pytest.raises(UnknownNameError, match="'milk_small'"):
        sbam.scene_from_demonstration(demonstration, sbam.ObjectLibrary(models))


def test_files_and_names_serve_wherever_what_they_hold_does(tmp_path: Path) -> None:
    model = sbam.learn("built-in:pouring")
    assert [one.name for one in model.demonstrations] == [one.name for one in sbam.load("built-in:pouring")]
    sbam.save_model(model, tmp_path / "pouring.json")
    sbam.save_scene(sbam.load_scene("built-in:pouring_new_layout"), tmp_path / "scene.yaml")
    hands = Path(sbam.__file__).parent / "robots" / "models" / "flying_hands.yaml"
    by_name = sbam.plan(tmp_path / "pouring.json", "built-in:pouring_new_layout", hands)
    by_file = sbam.plan(str(tmp_path / "pouring.json"), tmp_path / "scene.yaml", str(hands))
    assert by_name.ok and by_file.ok
    np.testing.assert_allclose(by_name.solution.configurations, by_file.solution.configurations, atol=1e-6)
    with pytest.raises(SbamError, match=r"nowhere.json"):
        sbam.plan(tmp_path / "nowhere.json", "built-in:pouring_new_layout")
    recording = tmp_path / "one.npz"
    sbam.write_demonstration(sbam.load("built-in:rolling")[0], recording)
    assert sbam.learn([recording]).demonstrations[0].name == "synthetic_rolling_0"
    assert sbam.scene_from_demonstration(recording).objects.keys() == sbam.load_scene(recording).objects.keys()
    with pytest.raises(DemonstrationError, match=r"several recordings, but one is needed.*synthetic_rolling_1"):
        sbam.replay("built-in:rolling")
    assert len(sbam.add_demonstration(sbam.learn(recording), "built-in:synthetic_rolling_1").demonstrations) == 2


def test_a_mode_beside_settings_of_another_one_is_refused() -> None:
    settings = sbam.LearningSettings.paper()
    with pytest.raises(SbamError, match=r"'mode' is 'default'; expected 'paper' as in the settings"):
        sbam.learn("built-in:rolling", mode="default", settings=settings)
    assert sbam.learn(sbam.load("built-in:rolling")[:1], settings=settings).mode == "paper"


def test_what_is_large_says_in_one_line_what_it_is(small_plan) -> None:
    model, demonstration = small_plan.task.model, sbam.load("built-in:pouring")[0]
    for thing, words in (
        (demonstration, (demonstration.name, "apple_juice", "frames", "left and right hands")),
        (model, (model.name, "cartesian", "demonstrations", "keypoints")),
        (small_plan, (small_plan.robot.name, small_plan.task.scene.name, "checks passed")),
        (replace(small_plan, problems=("late", "long")), ("2 problems",)),
    ):
        line, table = repr(thing), thing._repr_html_()
        assert len(line) < 200 and "\n" not in line
        assert all(word in line for word in words)
        assert table.startswith("<table>") and len(table) < 5000
    odd = replace(demonstration, name="<b>&")
    assert "<b>" not in odd._repr_html_() and "&lt;b&gt;&amp;" in odd._repr_html_()
