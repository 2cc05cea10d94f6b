"""The playback puts robot, fingers and objects where the plan has them."""

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.planning.plan import Plan
from sbam.scene import AffordanceRegion
from sbam.viewer.playback import Playback, ellipse_rotation


@pytest.fixture(scope="module")
def playback(small_plan: Plan) -> Playback:
    return Playback(small_plan)


def test_hands_and_objects_are_where_the_plan_has_them(small_plan: Plan, playback: Playback) -> None:
    samples = np.arange(0, len(small_plan.trajectory.time), 2500)
    frames = playback.frames(small_plan.trajectory.time[samples])
    hands = [arm.hand.body for arm in small_plan.robot.arms.values()]
    expected = small_plan.robot.kinematics(small_plan.trajectory.position[samples], hands)
    for k, hand in enumerate(hands):
        assert np.abs(frames.position[:, playback.model.body(hand).id] - expected.position[:, k]).max() < 1e-6
    for name, pose in small_plan.object_poses().items():
        body = playback.body(name)
        assert np.abs(frames.position[:, body] - pose[samples].translation).max() < 1e-6
        turned = Rotation.from_quat(frames.quaternion_wxyz[:, body], scalar_first=True)
        assert (turned.inv() * pose[samples].rotation).magnitude().max() < 1e-6


def test_a_single_time_is_the_same_as_many(playback: Playback) -> None:
    data = mujoco.MjData(playback.model)
    playback.set_time(data, 9.87)
    frames = playback.frames([3.0, 9.87])
    assert np.allclose(data.xpos, frames.position[1])
    assert np.allclose(data.xquat, frames.quaternion_wxyz[1])


def test_fingers_touch_what_they_hold_and_are_open_before_and_after(small_plan: Plan, playback: Playback) -> None:
    model, data = playback.model, mujoco.MjData(playback.model)
    for (role, hand), _ in small_plan.grasps.items():
        phases = {p.name: p for p in small_plan.phases if p.role == role and p.hand == hand}
        held = np.flatnonzero(model.geom_bodyid == playback.body(small_plan.task.binding[role]))
        fingers = [model.geom(f"{hand}_finger_{side}").id for side in "ab"]

        def gap(time: float, fingers=fingers, held=held) -> list[float]:
            playback.set_time(data, time)
            pairs = [[mujoco.mj_geomDistance(model, data, f, g, 1.0, None) for g in held] for f in fingers]
            return [min(distances) for distances in pairs]

        middle = 0.5 * (phases["manipulate"].start + phases["manipulate"].end)
        for time in (phases["grasp"].end, middle, phases["place"].start):
            assert np.abs(gap(time)).max() < 5e-4
        assert min(gap(phases["grasp"].start)) > 1e-3
        assert min(gap(phases["place"].end)) > 1e-3


def test_times_outside_are_the_ends(playback: Playback) -> None:
    inside = playback.frames([0.0, playback.duration])
    outside = playback.frames([-5.0, playback.duration + 5.0])
    assert np.array_equal(inside.position, outside.position)


def test_the_floor_is_below_everything_that_stands(small_plan: Plan, playback: Playback) -> None:
    table = small_plan.task.scene.objects["kitchen_sideboard"].geometry[0]
    under = small_plan.task.scene.T_world_object["kitchen_sideboard"] * table.T_object_primitive
    assert playback.floor < under.translation[2] - table.size[2]
    assert playback.floor > under.translation[2] - table.size[2] - 0.01


def test_moments_show_the_action(small_plan: Plan, playback: Playback) -> None:
    times = playback.moments(5)
    assert len(times) == 5
    assert (np.diff(times) > 0).all()
    assert playback.label(float(times[0])).startswith("left: ")
    assert "manipulate" in playback.label(float(times[2]))
    assert playback.label(small_plan.trajectory.duration + 1.0) == "rest"
    pose = playback.object_poses(times)["apple_juice"]
    all_tilts = (small_plan.object_poses()["apple_juice"].rotation.apply([0, 1, 0])[:, 2]).min()
    assert pose.rotation.apply([0, 1, 0])[:, 2].min() < all_tilts + 0.1


@pytest.mark.parametrize("normal", [(0, 0, 1), (0, 0, -1), (0, 1, 0), (0, -1, 0), (1, 0, 0), (0.6, 0, 0.8)])
def test_an_ellipse_lies_in_the_plane_of_its_region(normal) -> None:
    region = AffordanceRegion("place", np.zeros(3), np.array([0.2, 0.1]), np.array(normal, dtype=float))
    rotation = ellipse_rotation(region)
    assert np.allclose(rotation.apply([0, 0, 1]), normal, atol=1e-12)
    assert np.isclose(RigidTransform.from_rotation(rotation).rotation.magnitude(), np.arccos(normal[2]))
    if normal[0] == 0:
        assert np.allclose(rotation.apply([1, 0, 0]), [1, 0, 0])  # the long side of a table stays its long side
