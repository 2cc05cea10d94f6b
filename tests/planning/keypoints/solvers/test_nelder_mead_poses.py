"""The paper's solver finds poses of both hands, by what it changes: positions and orientations."""

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.planning.keypoints.problem import Problem
from sbam.planning.keypoints.solvers.nelder_mead import solve_nelder_mead
from sbam.planning.keypoints.state import Carrying, Workspace
from sbam.planning.keypoints.terms import Resting

HERE = RigidTransform.identity()


@pytest.mark.parametrize(
    ("moves", "turns"),
    [
        ([[0.04, -0.03, 0.02], [-0.02, 0.04, 0.03]], [[0.0, 0.2, 0.1], [0.25, 0.0, -0.1]]),
        ([[0.0, 0.0, 0.05], [0.0, 0.0, 0.0]], [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]),
        ([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]], [[0.0, 0.0, 0.0], [0.0, 0.2, 0.0]]),
    ],
    ids=["both hands move and turn", "one hand moves", "one hand turns"],
)
def test_hands_move_and_turn_to_where_the_objects_shall_be(robot_named, moves, turns):
    """Objects that coincide with their hands; a turn moves none and a move turns none."""
    robot = robot_named("flying_hands")
    workspace = Workspace(robot, [Carrying("a", "left", HERE), Carrying("b", "right", HERE)], [])
    start = np.zeros(14)
    start[:3], start[7:10] = [-0.2, 0.4, 0.3], [0.2, 0.4, 0.3]
    start[[4, 11]] = 0.8  # pitch, away from where the first and the last joint are one axis
    state = workspace.state(start[None])
    np.testing.assert_allclose(state.object_position[0], [[-0.2, 0.4, 0.3], [0.2, 0.4, 0.3]], atol=1e-12)
    wanted = state.object_position + np.array(moves)
    rotation = Rotation.from_rotvec(turns).as_matrix() @ state.object_rotation
    problem = Problem(workspace, (Resting(("a", "b"), np.ones((1, 2), dtype=bool), wanted, rotation),), 1)
    found = problem.state(solve_nelder_mead(problem, start).configurations)
    np.testing.assert_allclose(found.object_position, wanted, atol=1e-4)
    off = Rotation.from_matrix(found.object_rotation[0] @ rotation[0].mT)
    assert off.magnitude().max() < 1e-3
