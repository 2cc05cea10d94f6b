"""What a model bound to a scene moves, from where to where."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.demonstrations.scenes import starting_scene
from sbam.errors import BindingError, UnknownNameError
from sbam.planning.bind import bind
from sbam.scene import ObjectLibrary, Scene, upright_rotation


@pytest.fixture(scope="module")
def pouring(model_of):
    return model_of("pouring")


@pytest.fixture(scope="module")
def rolling(model_of):
    return model_of("rolling")


@pytest.fixture(scope="module")
def pouring_scene() -> Scene:
    return starting_scene("built-in:pouring_new_layout")


@pytest.fixture(scope="module")
def rolling_scene() -> Scene:
    return starting_scene("built-in:rolling")


def with_end(model, role: str, wanted: dict[str, np.ndarray]):
    """The model, its own-start pairs of a role ending displaced as wanted: affordance -> (3,) m."""
    changes = []
    for change in model.changes:
        if change.pair.is_own_start and change.pair.first.role == role:
            displacement = wanted[change.pair.first.affordance]
            channels = tuple(
                replace(channel, mean=np.append(channel.mean[:-1], value))
                for channel, value in zip(change.channels, displacement, strict=True)
            )
            change = replace(change, channels=channels)
        changes.append(change)
    return replace(model, changes=tuple(changes))


def displaced(scene: Scene, name: str, pose: RigidTransform) -> dict[str, np.ndarray]:
    """Displacements of an object's regions from its pose in the scene to another one, agent axes."""
    start = scene.T_world_agent.inv() * scene.T_world_object[name]
    return {r.affordance: pose.apply(r.center) - start.apply(r.center) for r in scene.objects[name].affordance_regions}


def moved_object(task, role: str):
    return next(moved for moved in task.moved if moved.role == role)


def test_binding_by_affordance(pouring, pouring_scene):
    task = bind(pouring, pouring_scene)
    assert task.binding == {"pour_from": "apple_juice", "pour_into": "cup_large", "place_onto": "kitchen_sideboard"}
    assert {moved.name for moved in task.moved} == {"apple_juice", "cup_large"}
    assert {moved.role: moved.hands for moved in task.moved} == {"pour_from": ("right",), "pour_into": ("left",)}


def test_two_hands_on_one_object(rolling, rolling_scene):
    (moved,) = bind(rolling, rolling_scene).moved
    assert (moved.name, moved.hands) == ("rolling_pin", ("left", "right"))


def test_times_are_those_of_the_events(pouring, pouring_scene):
    for moved in bind(pouring, pouring_scene).moved:
        lift, place = (
            next(anchor.time for anchor in pouring.anchors if (anchor.kind, anchor.role) == (kind, moved.role))
            for kind in ("lift", "place")
        )
        assert (moved.lift, moved.place) == (lift, place)
        assert moved.grasp <= moved.lift < moved.place <= moved.release


def test_poses_are_in_the_agent_frame(pouring, pouring_scene):
    """The built-in scene's agent looks along world x from the origin: right is -y, forward is x."""
    task = bind(pouring, pouring_scene)
    x, y, z = pouring_scene.T_world_object["cup_large"].translation
    np.testing.assert_allclose(task.T_agent_object["cup_large"].translation, [-y, x, z], atol=1e-12)
    reference = next(c.pair.first for c in pouring.changes if c.pair.first.affordance == "pour into")
    np.testing.assert_allclose(task.region_center(reference), [0.0, 0.130, 0.0])
    np.testing.assert_allclose(task.region_at_start(reference), [-y, x, z + 0.130], atol=1e-12)


def test_unknown_roles_and_unfit_objects(pouring, pouring_scene):
    with pytest.raises(UnknownNameError, match=r"unknown role 'stir'.*pour_from"):
        bind(pouring, pouring_scene, {"stir": "cup_large"})
    with pytest.raises(UnknownNameError, match="unknown object 'spoon'"):
        bind(pouring, pouring_scene, {"pour_from": "spoon"})
    with pytest.raises(BindingError, match=r"'cup_large' cannot play the role 'pour_from'.*lacks 'pour from'"):
        bind(pouring, pouring_scene, {"pour_from": "cup_large"})
    with pytest.raises(BindingError, match="no object can play the role 'pour_into'"):
        objects = {name: model for name, model in pouring_scene.objects.items() if name != "cup_large"}
        poses = {name: pouring_scene.T_world_object[name] for name in objects}
        bind(pouring, replace(pouring_scene, objects=objects, T_world_object=poses))


def test_a_standing_vessel_is_put_onto_its_support(pouring, pouring_scene):
    """Learned 8 mm too high and 3 cm aside: it stands there, on the table."""
    start = bind(pouring, pouring_scene).T_agent_object["apple_juice"]
    aside = np.array([0.03, -0.01, 0.008])
    model = with_end(pouring, "pour_from", {"place": aside, "pour from": aside + np.array([0.004, 0.0, 0.0])})
    put_down = moved_object(bind(model, pouring_scene), "pour_from").put_down
    np.testing.assert_allclose(put_down.translation, start.translation + np.array([0.03, -0.01, 0.0]), atol=1e-12)
    assert (put_down.rotation * start.rotation.inv()).magnitude() < 1e-9


def test_a_model_that_says_nothing_of_it_puts_things_back(model_of, pouring_scene):
    for moved in bind(model_of("pouring", mode="paper"), pouring_scene).moved:
        np.testing.assert_array_equal(moved.put_down.as_matrix(), moved.start.as_matrix())


@pytest.mark.parametrize("yaw_deg", [-100.0, -8.0, 0.0, 5.0, 90.0, 170.0])
def test_a_lying_pin_is_turned_as_learned(rolling, rolling_scene, yaw_deg):
    """Both handles end where a turn about the vertical and a shift bring them, 6 mm too high: it lies on the table."""
    start = bind(rolling, rolling_scene).T_agent_object["rolling_pin"]
    turned = Rotation.from_euler("z", yaw_deg, degrees=True) * start.rotation
    wanted = RigidTransform.from_components(start.translation + np.array([0.04, 0.10, 0.006]), turned)
    model = with_end(rolling, "handle_left", displaced(rolling_scene, "rolling_pin", wanted))
    (moved,) = bind(model, rolling_scene).moved
    np.testing.assert_allclose(moved.put_down.translation, wanted.translation - [0.0, 0.0, 0.006], atol=1e-9)
    assert (moved.put_down.rotation * wanted.rotation.inv()).magnitude() < 1e-6


@pytest.mark.parametrize("tilt_deg", [0.0, 30.0, 75.0])
def test_what_ends_in_the_air_stays_there(pouring, tilt_deg):
    """As in recordings that stop while the bottle is held: lifted by 25 cm and tilted, nothing is snapped."""
    library = ObjectLibrary.built_in()
    names = {"bottle": [0.2, 0.5, 0.0], "mug": [-0.1, 0.45, 0.0], "kitchen_sideboard": [0.0, 0.545, -0.024]}
    scene = Scene(
        name="bottle and mug",
        objects={name: library[name] for name in names},
        T_world_object={
            name: RigidTransform.from_components(position, upright_rotation(library[name].up, 0.0))
            for name, position in names.items()
        },
        T_world_agent=RigidTransform.identity(),
    )
    wanted = RigidTransform.from_components([0.0, 0.5, 0.25], Rotation.from_euler("y", -tilt_deg, degrees=True))
    model = with_end(pouring, "pour_from", displaced(scene, "bottle", wanted))
    put_down = moved_object(bind(model, scene), "pour_from").put_down
    np.testing.assert_allclose(put_down.as_matrix(), wanted.as_matrix(), atol=1e-9)


def test_one_hand_holds_one_object(model_of):
    model = model_of("pouring")
    right = tuple(replace(hold, hand="right") for hold in model.holds)
    with pytest.raises(BindingError, match=r"right hand holds '.*' and '.*' in this action"):
        bind(replace(model, holds=right), starting_scene("built-in:pouring_new_layout"))
