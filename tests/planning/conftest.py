"""Robots, learned models and plans that all tests of the planning share; none of them is to be changed."""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.demonstrations.scenes import starting_scene
from sbam.demonstrations.synthetic import BuiltInTask, built_in_demonstrations
from sbam.learning.learn import learn
from sbam.learning.model import ActionModel
from sbam.planning.keypoints.free_flight import flying_hands
from sbam.planning.keypoints.objective import build_problem
from sbam.planning.keypoints.problem import Problem
from sbam.planning.keypoints.state import Carrying, RegionPoint, Workspace
from sbam.planning.plan import Plan, plan
from sbam.planning.start import in_agent_frame
from sbam.robots import Robot, load_robot

ROBOTS = ("panda_dual", "flying_hands")


@cache
def learned(task: BuiltInTask, constraint: str = "cartesian", mode: str = "default") -> ActionModel:
    return learn(built_in_demonstrations(task)[::3], constraint, mode=mode)


@cache
def robot_in_agent_frame(name: str) -> Robot:
    robot = flying_hands() if name == "flying_hands" else load_robot(name)
    return in_agent_frame(robot)


@pytest.fixture(scope="session")
def model_of() -> Callable[..., ActionModel]:
    """``model_of(task, constraint, mode)``: learned from every third built-in demonstration."""
    return learned


@pytest.fixture(scope="session")
def robot_named() -> Callable[[str], Robot]:
    """``robot_named(name)``: standing where it belongs in the agent frame."""
    return robot_in_agent_frame


@pytest.fixture(scope="session")
def rolling_plan() -> Plan:
    """Rolling in the built-in scene."""
    return plan(learned("rolling"), starting_scene("built-in:rolling"))


@pytest.fixture(scope="session")
def problem_of() -> Callable[..., Problem]:
    """``problem_of(plan, times)``: a plan's problem, at all of its keypoints or at other times, s."""

    def build(made: Plan, times: np.ndarray | None = None) -> Problem:
        grasps = {key: grasp.T_object_tcp for key, grasp in made.grasps.items()}
        return build_problem(made.task, in_agent_frame(made.robot), grasps, made.settings, times)

    return build


@pytest.fixture(params=ROBOTS)
def workspace(request: pytest.FixtureRequest) -> Workspace:
    """Each hand carries an object at a random pose in it; two regions a hand, two that stand still."""
    robot = robot_in_agent_frame(request.param)
    generator = np.random.default_rng(3)
    carryings = [
        Carrying(
            f"object of the {arm} hand",
            arm,
            RigidTransform.from_components(generator.normal(0, 0.1, 3), Rotation.random(rng=generator)),
        )
        for arm in robot.arms
    ]
    owners = (0, 1, -1, 1, -1, 0)
    regions = [RegionPoint(owner, generator.normal(0, 0.1 if owner >= 0 else 0.5, 3)) for owner in owners]
    return Workspace(robot, carryings, regions)
