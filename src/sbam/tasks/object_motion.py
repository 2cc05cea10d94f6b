"""Where the objects of a task are over time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from sbam.constraints import RegionReference
from sbam.planning.task import Task

Array = NDArray[np.float64]


class ObjectMotion(Protocol):
    """A plan, or another motion of the objects, in N samples."""

    @property
    def task(self) -> Task:
        """The model bound to the scene."""
        ...

    @property
    def time(self) -> Array:
        """(N,) s from the first sample."""
        ...

    @property
    def model_time(self) -> Array:
        """(N,) time on the model's axis of every sample, s."""
        ...

    @property
    def T_agent_object(self) -> Mapping[str, RigidTransform]:
        """Object name -> N poses of every moved object, agent frame."""
        ...


def roles_poses(motion: ObjectMotion) -> dict[str, RigidTransform]:
    """Role -> N poses of every moved object, agent frame."""
    return {moved.role: motion.T_agent_object[moved.name] for moved in motion.task.moved}


def region_path(motion: ObjectMotion, role: str, affordance: str) -> Array:
    """(N, 3) centre of a role's region at every sample, agent frame, m."""
    return region_points(motion.task, roles_poses(motion), RegionReference(role, affordance), len(motion.model_time))


def region_points(
    task: Task, T_agent_role: Mapping[str, RigidTransform], reference: RegionReference, count: int
) -> Array:
    """(N, 3) centre of a role's region, agent frame, m.

    Args:
        task: the model bound to the scene.
        T_agent_role: role -> N poses of every moved object; what is missing stands where it stood at the start.
        reference: the region.
        count: N.
    """
    if reference.role in T_agent_role:
        return T_agent_role[reference.role].apply(task.region_center(reference))
    return np.broadcast_to(task.region_at_start(reference), (count, 3))
