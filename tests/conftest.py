"""Fixtures shared by all tests."""

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from sbam.demonstrations.scenes import starting_scene
from sbam.demonstrations.synthetic import built_in_demonstrations
from sbam.learning.learn import learn
from sbam.planning.plan import Plan, plan
from sbam.robots import Robot, load_robot

REPOSITORY = Path(__file__).parents[1]


@pytest.fixture(scope="session")
def recordings_folder() -> Path:
    """Folder of third-party recordings (not part of the project); tests that need it skip where it is absent."""
    folder = Path(os.environ.get("SBAM_DATA", REPOSITORY.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"third-party recordings not found at {folder}; set SBAM_DATA")
    return folder


@pytest.fixture(scope="session")
def small_plan() -> Plan:
    """Pouring, learned from four of the built-in demonstrations and planned in another scene; not to be changed."""
    model = learn(built_in_demonstrations("pouring")[::3])
    return plan(model, starting_scene("built-in:pouring_new_layout"))


@pytest.fixture(scope="session")
def panda() -> Robot:
    """The bimanual Panda where it belongs in the agent frame."""
    return load_robot("panda_dual").placed_for(RigidTransform.identity())


@pytest.fixture(scope="session")
def within_limits() -> Callable[..., np.ndarray]:
    """``within_limits(robot, generator, count, share)``: random configurations, (count, n)."""

    def configurations(robot: Robot, generator: np.random.Generator, count: int, share: float = 0.9) -> np.ndarray:
        lower = np.where(np.isfinite(robot.lower), robot.lower, -np.pi)
        upper = np.where(np.isfinite(robot.upper), robot.upper, np.pi)
        middle, half = 0.5 * (lower + upper), 0.5 * share * (upper - lower)
        return generator.uniform(middle - half, middle + half, (count, len(lower)))

    return configurations
