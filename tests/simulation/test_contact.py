"""A gripper that closes on a block, lifts it and holds it, by the contact of its fingers."""

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

import sbam
from sbam.errors import SimulationError, UnknownNameError
from sbam.robots.jacobian import point_jacobian
from sbam.scene import AffordanceRegion, ObjectModel, Primitive, Scene
from sbam.simulation import simulate
from sbam.simulation.holding import check_grasp
from sbam.simulation.report import simulation_report
from sbam.tasks import PhysicsTask
from sbam.tasks.action import Action, Arms, Grip

RISE = 0.06  # m


class Lifting(PhysicsTask):
    """The block shall be lifted."""

    name = "lifting"

    def measure(self, action, record):
        return {"lifted": float(np.ptp(record.T_world_object["block"].translation[:, 2]))}

    def judge(self, values, yardstick):
        return [] if values["lifted"] > 0.8 * RISE else ["it stays where it is"]


def box(name: str, half: list[float], movable: bool) -> ObjectModel:
    part = Primitive("box", np.array(half), RigidTransform.identity(), np.ones(4))
    up = np.array([0.0, 0.0, 1.0])
    top = AffordanceRegion("place" if movable else "place onto", np.array([0, 0, half[2]]), np.full(2, 0.02), up)
    return ObjectModel(name, (top,), (part,), (), up, movable, 0.4)


@pytest.fixture(scope="module")
def lift() -> Action:
    """The right Panda stands at home over a block on a stand, closes its fingers and goes straight up."""
    robot = sbam.load_robot("panda_dual")
    arm = robot.arms["right"]
    time = np.arange(0.0, 2.6, 0.01)
    height = RISE * np.clip((time - 0.8) / 0.8, 0.0, 1.0)
    position = np.tile(robot.home, (len(time), 1))
    mask = robot.frame_joints(arm.tcp_frame)
    for i in range(1, len(time)):  # along the Jacobian: straight enough over 6 cm
        kinematics = robot.kinematics(position[i - 1 : i], [arm.tcp_frame])
        tcp = kinematics.position[:, 0]
        jacobian = np.vstack(
            [point_jacobian(kinematics, tcp, mask)[0], (kinematics.joint_axis[0] * mask[:, None]).T],
        )
        rise = np.array([0.0, 0.0, height[i] - height[i - 1], 0.0, 0.0, 0.0])
        position[i] = position[i - 1] + np.linalg.pinv(jacobian, rcond=1e-6) @ rise
    velocity = np.gradient(position, time, axis=0)
    start = robot.kinematics(robot.home[None], [arm.tcp_frame])
    at = start.position[0, 0]
    T_world_tcp = RigidTransform.from_components(at, Rotation.from_matrix(start.rotation[0, 0]))
    block, stand = box("block", [0.025, 0.025, 0.05], True), box("stand", [0.05, 0.05, 0.02], False)
    T_world_block = RigidTransform.from_translation(at - [0.0, 0.0, 0.03])
    scene = Scene(
        name="lifting",
        objects={"block": block, "stand": stand},
        T_world_object={
            "block": T_world_block,
            "stand": RigidTransform.from_translation(at - [0.0, 0.0, 0.03 + 0.05 + 0.02]),
        },
        T_world_agent=robot.T_world_agent,
    )
    grip = Grip("right", "block", T_world_block.inv() * T_world_tcp, 0.05, 0.7, 2.6, 0.1, 2.7)
    trajectory = sbam.JointTrajectory(robot.joint_names, time, position, velocity, 0.0 * velocity)
    return Action("lifting", scene, {}, time, {}, Arms(robot, trajectory, (grip,)))


def test_fingers_hold_what_they_press(lift: Action) -> None:
    result = simulate(lift, Lifting(), grasp="contact")
    assert result.ok, result.problems
    slip = result.record.slip["right", "block"]
    assert 0.0 < slip.most < 0.004
    assert np.rad2deg(slip.most_angle) < 5.0
    assert not result.record.contacts
    report = simulation_report(result)
    assert report["slip_m"] == {"right hand, block": pytest.approx(slip.most)}
    assert len(report["series"]["slip"]["right hand, block"]["slip [mm]"]) == len(slip.time)
    assert "contact" in report["assumptions"][0]


def test_a_grasp_with_too_little_force_drops_the_block(lift: Action) -> None:
    result = simulate(lift, Lifting(), grasp="contact", grasp_force=0.5)
    assert not result.ok
    assert any("slips" in problem or "drops" in problem for problem in result.problems)
    assert result.values["lifted"] < 0.5 * RISE


def test_the_default_is_a_grasp_that_is_assumed(lift: Action) -> None:
    result = simulate(lift, Lifting())
    assert result.ok, result.problems
    assert result.record.slip["right", "block"].most < 5e-4
    assert "grasp assumed" in simulation_report(result)["assumptions"][0]


def test_hands_without_moving_fingers_are_told_which_can(lift: Action) -> None:
    robot = sbam.load_robot("armar6")
    still = np.tile(robot.home, (2, 1))
    trajectory = sbam.JointTrajectory(robot.joint_names, np.array([0.0, 0.3]), still, 0.0 * still, 0.0 * still)
    action = Action("rest", lift.scene, {}, trajectory.time, {}, Arms(robot, trajectory, ()))
    with pytest.raises(SimulationError, match=r"armar6 do not move.*panda_dual"):
        check_grasp(action, "contact")
    with pytest.raises(UnknownNameError, match="contact"):
        check_grasp(action, "glue")
    with pytest.raises(SimulationError, match="force above 0"):
        simulate(lift, Lifting(), grasp="contact", grasp_force=0.0)
