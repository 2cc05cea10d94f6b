"""Where the objects of a task are over time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import RigidTransform

from sbam.constraints import RegionReference
from sbam.planning.task import Task


class ObjectMotion(Protocol):
    """A plan, or another motion of the objects, in N samples."""

    @property
    def task(self) -> Task:
        """The model bound to the scene."""
        ...

    @property
    def time(self) -> Float[np.ndarray, " samples"]:
        """Time from the first sample, s."""
        ...

    @property
    def model_time(self) -> Float[np.ndarray, " samples"]:
        """Time on the model's axis of every sample, s."""
        ...

    @property
    def T_agent_object(self) -> Mapping[str, RigidTransform]:
        """Object name -> poses of every moved object, agent frame."""
        ...


def roles_poses(motion: ObjectMotion) -> dict[str, RigidTransform]:
    """Role -> poses of every moved object, agent frame."""
    return {moved.role: motion.T_agent_object[moved.name] for moved in motion.task.moved}


def region_path(motion: ObjectMotion, role: str, affordance: str) -> Float[np.ndarray, "samples 3"]:
    """Centre of a role's region at every sample, agent frame, m."""
    return region_points(motion.task, roles_poses(motion), RegionReference(role, affordance), len(motion.model_time))


def region_points(
    task: Task, T_agent_role: Mapping[str, RigidTransform], reference: RegionReference, count: int
) -> Float[np.ndarray, "samples 3"]:
    """Centre of a role's region, agent frame, m.

    Args:
        task: the model bound to the scene.
        T_agent_role: role -> poses of every moved object; what is missing stands where it stood at the start.
        reference: the region.
        count: number of samples.
    """
    if reference.role in T_agent_role:
        return T_agent_role[reference.role].apply(task.region_center(reference))
    return np.broadcast_to(task.region_at_start(reference), (count, 3))
