"""Plans of a robot in physics, by way of the folders and the command line that users use."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest

import sbam
from sbam.cli import main
from sbam.results import write_results
from sbam.simulation.plan_folder import read_plan_folder
from sbam.simulation.run import World
from sbam.tasks import TASKS, PhysicsTask
from sbam.tasks.action import Action, Arms

COMPARED = "built-in:synthetic_rolling_0"


class Nothing(PhysicsTask):
    """A task that asks for nothing."""

    def measure(self, action, record):
        return {}

    def judge(self, values, yardstick):
        return []


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """A fast plan of rolling, as `sbam plan` writes it."""
    folder = tmp_path_factory.mktemp("rolling")
    model = sbam.learn(sbam.load("built-in:rolling")[::4])
    write_results(sbam.plan(model, sbam.load_scene("built-in:rolling"), settings=sbam.PlanSettings(speed=1.0)), folder)
    return folder


@pytest.fixture(scope="module")
def report(folder: Path) -> dict:
    with pytest.MonkeyPatch.context() as patch:  # a machine without the library
        patch.delenv("MUJOCO_GL", raising=False)
        patch.setitem(sys.modules, "mujoco.egl", None)
        file = folder / "physics.json"
        code = main(
            [
                "simulate",
                str(folder),
                "--demonstrations",
                COMPARED,
                "--video",
                str(folder / "a.png"),
                "--json",
                str(file),
            ]
        )
    found = json.loads(file.read_text())
    assert code == (0 if found["ok"] else 1)
    return found


def test_arms_follow_and_the_grasp_is_said_to_be_assumed(report: dict) -> None:
    assert report["robot"] == "panda_dual"
    assert report["task"] == "rolling"
    assert "grasp assumed" in report["assumptions"][0]
    assert len(report["tracking_error"]) == 14
    assert 0.0 < max(report["tracking_error"].values()) < 0.05
    assert 0.1 < max(report["torque_ratio"].values()) <= 1.0
    assert max(report["slip_m"].values()) < 0.005


def test_rolled_dough_is_as_planned(report: dict) -> None:
    assert report["ok"], report["problems"]
    assert report["values"]["off the planned thickness, 95 % [mm]"] < 1.0
    assert report["yardstick"]["demonstrations"] == ["synthetic_rolling_0"]


def test_without_opengl_physics_runs_and_says_what_is_missing(report: dict) -> None:
    assert report["files"] == []
    assert any("apt install" in warning for warning in report["warnings"])


def test_servos_do_not_sag_under_gravity(folder: Path) -> None:
    """Held at its start for a while, the robot stays where it is commanded to be."""
    import mujoco

    world = World(read_plan_folder(folder), TASKS["rolling"])
    data = mujoco.MjData(world.model)
    assert world.control is not None
    world.control.reset(data)
    times = np.zeros(1)
    data.ctrl[:] = world.control.commands(times)[0]
    for _ in range(250):
        mujoco.mj_step(world.model, data)
    assert np.abs(world.control.tracking_error(data, world.control.wanted(times)[0][0])).max() < 1e-3
    torque = world.control.torque(data)
    mujoco.mj_forward(world.model, data)
    assert torque == pytest.approx(data.qfrc_bias[world.control._dof[world.control.planned]], rel=0.05, abs=0.3)


def test_joints_that_are_not_planned_are_braked() -> None:
    """A humanoid's torso carries more than a finger's force; it must not sag."""
    import mujoco

    robot = sbam.load_robot("armar6")
    still = np.tile(robot.home, (2, 1))
    trajectory = sbam.JointTrajectory(robot.joint_names, np.array([0.0, 0.3]), still, 0.0 * still, 0.0 * still)
    scene = sbam.load_scene("built-in:rolling")
    world = World(Action("rest", scene, {}, trajectory.time, {}, Arms(robot, trajectory, ())), Nothing())
    assert {world.model.actuator(i).name for i in range(world.model.nu)} == set(robot.joint_names)
    data, reference = mujoco.MjData(world.model), mujoco.MjData(robot.model)
    assert world.control is not None
    world.control.reset(data)
    data.ctrl[:] = world.control.commands(np.zeros(1))[0]
    for _ in range(100):
        mujoco.mj_step(world.model, data)
    reference.qpos[:] = robot.home
    mujoco.mj_kinematics(robot.model, reference)
    assert data.body("torso").xpos == pytest.approx(reference.body("torso").xpos)
    assert data.body("left_hand").xpos == pytest.approx(reference.body("left_hand").xpos, abs=1e-3)


@pytest.mark.parametrize("arguments", [[], ["a", "--sweep", "b"], ["--sweep", "b", "--scenes", "0"]])
def test_wrong_usage(arguments: list[str]) -> None:
    with pytest.raises(SystemExit) as left:
        main(["simulate", *arguments])
    assert left.value.code == 2
