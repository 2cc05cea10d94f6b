"""From model and scene to a verified trajectory."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.demonstrations.scenes import starting_scene
from sbam.demonstrations.synthetic import built_in_demonstrations
from sbam.errors import BindingError, SbamError, UnreachableError
from sbam.learning.learn import learn
from sbam.planning.plan import Plan, plan
from sbam.planning.settings import PlanSettings
from sbam.scene import Scene
from sbam.tasks import measure_pouring, measure_put_down, measure_rolling


def moved(scene: Scene, name: str, by) -> Scene:
    """The scene with an object moved in the world, m."""
    poses = {**scene.T_world_object, name: RigidTransform.from_translation(by) * scene.T_world_object[name]}
    return replace(scene, T_world_object=poses)


def assert_good(planned: Plan) -> None:
    assert planned.ok, planned.problems
    assert all(check.ok for check in planned.checks)
    for measure in (measure_pouring(planned), measure_put_down(planned)):
        assert measure.ok, measure.problems


def test_pouring_in_a_new_layout(small_plan):
    assert_good(small_plan)
    assert small_plan.solution.solver == "default"
    assert len(small_plan.model_time) == len(small_plan.trajectory.time)
    assert set(small_plan.T_agent_object) == {"apple_juice", "cup_large"}


def test_rolling(rolling_plan):
    assert rolling_plan.ok, rolling_plan.problems
    for measure in (measure_rolling(rolling_plan), measure_put_down(rolling_plan)):
        assert measure.ok, measure.problems


@pytest.mark.parametrize("constraint", ["cylindrical", "symbolic"])
def test_the_other_constraint_types(model_of, constraint):
    planned = plan(model_of("pouring", constraint), starting_scene("built-in:pouring_new_layout"))
    assert planned.ok, planned.problems
    measure = measure_put_down(planned)
    assert measure.ok, measure.problems
    assert measure_pouring(planned).values["largest tilt [deg]"] > 60.0


@pytest.mark.parametrize("robot", ["panda_dual", "armar6", "armar7"])
def test_other_objects_with_the_same_affordances(robot):
    """A model of juice and the large cup, a scene with milk and the small cup."""
    model = learn(built_in_demonstrations("pouring")[:9])
    demonstrated = {name for role in model.roles for name in role.demonstrated}
    assert demonstrated == {"apple_juice", "cup_large", "kitchen_sideboard"}
    planned = plan(model, starting_scene("built-in:pouring_milk"), robot)
    assert_good(planned)
    assert planned.task.binding["pour_from"] == "milk_small"
    assert planned.task.binding["pour_into"] == "cup_small"


def test_the_same_again(model_of, rolling_plan):
    stages = []
    again = plan(model_of("rolling"), starting_scene("built-in:rolling"), progress=stages.append)
    for field in ("time", "position", "velocity", "acceleration"):
        np.testing.assert_array_equal(getattr(again.trajectory, field), getattr(rolling_plan.trajectory, field))
    assert again.checks == rolling_plan.checks
    assert {"variant", "bind", "free flight", "grasps", "keypoints", "motion", "avoidance", "timing", "checks"} == set(
        stages
    )
    assert set(again.seconds) == set(stages)


def test_the_trajectory_starts_and_ends_at_home(small_plan, rolling_plan):
    for planned in (small_plan, rolling_plan):
        home = planned.robot.clip(planned.robot.home)
        np.testing.assert_allclose(planned.trajectory.position[[0, -1]], np.stack([home, home]), atol=1e-9)


def test_poses_in_the_world_are_those_in_the_agent_frame(small_plan):
    world = small_plan.object_poses()
    assert set(world) == {"apple_juice", "cup_large"}
    for entry in small_plan.task.moved:
        scene = small_plan.task.scene
        np.testing.assert_allclose(
            world[entry.name][0].as_matrix(), scene.T_world_object[entry.name].as_matrix(), atol=1e-9
        )


@pytest.mark.parametrize("name", ["cup_large", "apple_juice"])
def test_out_of_reach_says_which_hand_and_what(model_of, name):
    """90 cm farther away. Where the cup is out of reach the bottle that is poured from is as well."""
    scene = moved(starting_scene("built-in:pouring_new_layout"), name, [0.9, 0.0, 0.0])
    with pytest.raises(UnreachableError, match=r"panda_dual's (left|right) hand") as error:
        plan(model_of("pouring"), scene)
    assert "'apple_juice'" in str(error.value) or f"'{name}'" in str(error.value)


def test_a_pin_out_of_reach(model_of):
    with pytest.raises(UnreachableError, match=r"panda_dual's (left|right) hand .*'rolling_pin'"):
        plan(model_of("rolling"), moved(starting_scene("built-in:rolling"), "rolling_pin", [0.6, 0.0, 0.0]))


def test_a_scene_in_millimetres_is_out_of_reach(model_of):
    scene = starting_scene("built-in:pouring_new_layout")
    poses = {
        name: RigidTransform.from_components(1000.0 * pose.translation, pose.rotation)
        for name, pose in scene.T_world_object.items()
    }
    with pytest.raises(SbamError):
        plan(model_of("pouring"), replace(scene, T_world_object=poses))


def test_a_scene_without_vessels(model_of):
    with pytest.raises(BindingError, match=r"'pour_from' \(affords place, pour from"):
        plan(model_of("pouring"), starting_scene("built-in:rolling"))


def test_a_slower_robot_takes_longer_at_any_sample_rate(model_of, rolling_plan):
    settings = PlanSettings(speed=0.3, sample_rate=100.0)
    slow = plan(model_of("rolling"), starting_scene("built-in:rolling"), settings=settings)
    assert slow.ok, slow.problems
    np.testing.assert_allclose(np.diff(slow.trajectory.time), 0.01)
    assert slow.trajectory.duration > 1.1 * rolling_plan.trajectory.duration
    assert np.abs(slow.trajectory.velocity / slow.robot.velocity_limit).max() <= 0.3


def test_the_robot_stands_in_the_agent_frame_wherever_the_scene_is(model_of, rolling_plan):
    """Scene and agent turned and shifted together: the same plan, elsewhere."""
    scene = rolling_plan.task.scene
    shift = RigidTransform.from_components([3.0, -2.0, 0.8], Rotation.from_euler("z", 130.0, degrees=True))
    poses = {name: shift * pose for name, pose in scene.T_world_object.items()}
    elsewhere = replace(scene, T_world_object=poses, T_world_agent=shift * scene.T_world_agent)
    planned = plan(model_of("rolling"), elsewhere, settings=PlanSettings(sample_rate=100.0))
    assert planned.ok, planned.problems
    np.testing.assert_allclose(planned.solution.objective, rolling_plan.solution.objective, rtol=1e-3)
    expected = shift * rolling_plan.object_poses()["rolling_pin"][-1]
    np.testing.assert_allclose(planned.object_poses()["rolling_pin"][-1].as_matrix(), expected.as_matrix(), atol=1e-6)
