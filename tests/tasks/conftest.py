"""Motions of objects, spoilt."""

from collections.abc import Callable
from dataclasses import replace

import pytest
from scipy.spatial.transform import RigidTransform

from sbam.planning.plan import Plan

Change = Callable[[RigidTransform], RigidTransform]


@pytest.fixture
def spoilt() -> Callable[..., Plan]:
    """``spoilt(plan, role, change, where)``: the plan with poses (a selection of samples) of one object changed."""

    def change_poses(made: Plan, role: str, change: Change, where: slice = slice(None)) -> Plan:
        name = made.task.binding[role]
        pose = made.T_agent_object[name]
        matrices = pose.as_matrix().copy()
        matrices[where] = change(pose[where]).as_matrix()
        return replace(made, T_agent_object={**made.T_agent_object, name: RigidTransform.from_matrix(matrices)})

    return change_poses


@pytest.fixture
def shifted() -> Callable[..., Change]:
    """``shifted(by)``: a change that moves poses, m."""
    return lambda by: lambda pose: RigidTransform.from_translation(by) * pose
