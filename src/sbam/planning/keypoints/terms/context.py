"""What a term is made of: the task, the robot and its grasps, and the times it is to hold at."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import RigidTransform

from sbam.constraints import RegionReference
from sbam.demonstrations.demonstration import Hand
from sbam.planning.keypoints.terms.base import Term
from sbam.planning.settings import PlanSettings
from sbam.planning.task import Task
from sbam.robots import Robot


@dataclass(frozen=True)
class TermContext:
    """The problem that terms are made for; everything is in the agent frame, m and rad.

    Attributes:
        task: the model bound to a scene.
        robot: the robot, standing in the agent frame; in the free flight, hands without arms.
        T_object_tcp: (role, hand) -> grasp.
        regions: the regions whose centres are ``State.region_position``, in its order.
        times: keypoints on the model's time axis, s.
        settings: weights of the terms.
        free_flight: whether it is asked where the objects would go if no robot had to hold them. Terms that are
            ``about_posture`` are left out then and need not be made.
    """

    task: Task
    robot: Robot
    T_object_tcp: Mapping[tuple[str, Hand], RigidTransform]
    regions: tuple[RegionReference, ...]
    times: Float[np.ndarray, " keypoints"]
    settings: PlanSettings
    free_flight: bool = False

    @property
    def roles(self) -> tuple[str, ...]:
        """Roles of the carried objects, in the order of ``State.object_position`` and ``object_rotation``."""
        return tuple(moved.role for moved in self.task.moved)

    @property
    def arms(self) -> tuple[str, ...]:
        """The arms, in the order of the first frames of ``State.kinematics``: their tool centre points."""
        return tuple(self.robot.arms)


@runtime_checkable
class TermFactory(Protocol):
    """Makes the terms of one kind for a problem, none where it has nothing to say."""

    def __call__(self, context: TermContext, /) -> Sequence[Term]:
        """The terms."""
        ...
