"""t_h in joint space as a term; the posture itself is tested with the robots."""

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from sbam.planning.keypoints.state import Workspace
from sbam.planning.keypoints.terms import JointHumanLikeness
from sbam.robots import load_robot
from sbam.robots.natural_joints import NaturalJoints


@pytest.fixture
def case():
    robot = load_robot("armar6").placed_for(RigidTransform.identity())
    posture = NaturalJoints(robot)
    q = robot.clip(robot.home + np.random.default_rng(4).normal(0, 0.3, (5, len(robot.home))))
    return JointHumanLikeness(3.0, posture, tuple(robot.arms)), Workspace(robot, [], [], posture.frames).state(q)


def test_jacobian_is_that_of_differences(case, agrees_with_differences, is_the_row_of_the_whole):
    agrees_with_differences(*case)
    is_the_row_of_the_whole(*case)


def test_cost_is_the_weighted_norm_of_each_arm(case):
    term, state = case
    expected = 3.0 * term.posture.value(state.kinematics, state.configurations)
    np.testing.assert_allclose(term.cost(state), expected, rtol=1e-9)
