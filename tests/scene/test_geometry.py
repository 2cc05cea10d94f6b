"""Poses of agents and standing objects."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.scene import (
    ObjectLibrary,
    Scene,
    agent_heading_deg,
    agent_pose,
    region_centers,
    support_height,
    upright_rotation,
)

ANGLE = st.floats(-720, 720)


@settings(deadline=None)
@given(ANGLE)
def test_the_agent_looks_along_its_heading(heading: float) -> None:
    pose = agent_pose([1, 2, 3], heading)
    forward = [np.cos(np.radians(heading)), np.sin(np.radians(heading)), 0]
    np.testing.assert_allclose(pose.rotation.apply([0, 1, 0]), forward, atol=1e-12)
    np.testing.assert_allclose(pose.rotation.apply([0, 0, 1]), [0, 0, 1], atol=1e-12)
    np.testing.assert_allclose(pose.rotation.apply([1, 0, 0]), np.cross(forward, [0, 0, 1]), atol=1e-12)
    np.testing.assert_allclose(pose.translation, [1, 2, 3])
    assert np.isclose((agent_heading_deg(pose) - heading + 180) % 360, 180, atol=1e-9)


def test_the_heading_of_the_recorded_people() -> None:
    """They stand at world +x and look along -x: x right is world +y, y forward is world -x."""
    np.testing.assert_allclose(agent_pose([0, 0, 0], 180).rotation.apply([1, 0, 0]), [0, 1, 0], atol=1e-12)


def test_a_tilted_agent_frame_is_refused() -> None:
    with pytest.raises(ValueError, match="gravity-aligned"):
        agent_heading_deg(RigidTransform.from_rotation(Rotation.from_euler("x", 5, degrees=True)))


@settings(deadline=None)
@given(st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: np.linalg.norm(v) > 0.1), ANGLE)
def test_an_upright_object_points_up(up: tuple[float, float, float], yaw: float) -> None:
    unit = np.array(up) / np.linalg.norm(up)
    rotation = upright_rotation(unit, yaw)
    np.testing.assert_allclose(rotation.apply(unit), [0, 0, 1], atol=1e-9)
    unturned = Rotation.from_euler("z", -yaw, degrees=True) * rotation
    assert np.isclose(unturned.magnitude(), np.arccos(np.clip(unit[2], -1, 1)), atol=1e-6), "the shortest rotation"


@pytest.mark.parametrize("up", [[0, 1, 0], [0, 0, 1], [0, 0, -1]])
def test_yaw_is_the_direction_of_the_local_x_axis(up: list[float]) -> None:
    direction = upright_rotation(np.array(up, dtype=float), 30).apply([1, 0, 0])
    np.testing.assert_allclose(direction, [np.cos(np.pi / 6), 0.5, 0], atol=1e-12)


def scene(**positions: tuple[float, float, float]) -> Scene:
    library = ObjectLibrary.built_in()
    return Scene(
        name="test",
        objects={name: library[name] for name in positions},
        T_world_object={
            name: RigidTransform.from_components(np.array(position), upright_rotation(library[name].up, 0))
            for name, position in positions.items()
        },
        T_world_agent=agent_pose([0, 0, 0], 0),
    )


def test_the_support_is_the_table_s_top_else_the_lowest_bottom() -> None:
    cups = {"cup_small": (0.0, 0.0, 0.8), "mug": (0.3, 0.0, 0.7)}
    assert np.isclose(support_height(scene(kitchen_sideboard=(0, 0, 0.6), **cups)), 0.624)
    assert np.isclose(support_height(scene(**cups)), 0.7)
    assert np.isclose(support_height(scene(rolling_pin=(0, 0, 0.5))), 0.5)


def test_a_table_upside_down_is_no_support() -> None:
    upside_down = scene(kitchen_sideboard=(0, 0, 0.9), mug=(0.3, 0.0, 0.7))
    turned = RigidTransform.from_components(np.array([0, 0, 0.9]), Rotation.identity())
    flipped = Scene("", upside_down.objects, {**upside_down.T_world_object, "kitchen_sideboard": turned}, turned)
    assert np.isclose(support_height(flipped), 0.7)


def test_region_centers_are_in_the_world() -> None:
    centers = region_centers(scene(cup_small=(0.1, 0.2, 0.3), mug=(0, 0, 0), milk_small=(1, 0, 0)), "pour into")
    assert set(centers) == {"cup_small", "mug"}
    np.testing.assert_allclose(centers["cup_small"], [0.1, 0.2, 0.39])
