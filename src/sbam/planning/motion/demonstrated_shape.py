"""The demonstrated shape of the objects' paths between keypoints, as movement primitives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation, Slerp

from sbam.learning.anchors import locate_anchors, warp
from sbam.learning.model import ActionModel
from sbam.learning.movement_primitive import MovementPrimitive, learn_primitive
from sbam.learning.sketch import DemonstrationSketch
from sbam.planning.task import MovedObject, Task

STEP = 0.02  # s between the samples that a primitive is learned from
POSITION_SPREAD = 0.02  # m: how readily the demonstrated shape is left for a keypoint
ROTATION_SPREAD = 0.1  # rad


@dataclass(frozen=True)
class DemonstratedShape:
    """How an object moves from its lift to its place.

    Attributes:
        position: path of the acting point, agent frame, m.
        rotation: rotation vectors that come after the shortest turns from keypoint to keypoint, object frame, rad.
    """

    position: MovementPrimitive
    rotation: MovementPrimitive


def demonstrated_shapes(task: Task, acting: Mapping[str, tuple[str, ...]]) -> dict[str, DemonstratedShape]:
    """Learn the shapes of a task's moved objects from what its model keeps of the demonstrations.

    Args:
        task: model bound to a scene.
        acting: role -> affordances whose regions' mean is the point that acts.

    Returns:
        Role -> shape; roles of which no demonstration has kept a path are left out.
    """
    shapes = {}
    for moved in task.moved:
        shape = _shape(task.model, moved, acting[moved.role])
        if shape is not None:
            shapes[moved.role] = shape
    return shapes


def _shape(model: ActionModel, moved: MovedObject, affordances: tuple[str, ...]) -> DemonstratedShape | None:
    time = np.linspace(moved.lift, moved.place, max(10, round((moved.place - moved.lift) / STEP) + 1))
    inside = (model.keypoint_times > moved.lift + 1e-6) & (model.keypoint_times < moved.place - 1e-6)
    keypoints = np.concatenate([[moved.lift], model.keypoint_times[inside], [moved.place]])
    found = [_demonstrated(model, sketch, moved.role, affordances, time) for sketch in model.demonstrations]
    paths = [path for path in found if path is not None]
    if not paths:
        return None
    turns = []
    for _, rotation in paths:
        at_keypoints = Slerp(time, rotation)(keypoints)
        turns.append((Slerp(keypoints, at_keypoints)(time).inv() * rotation).as_rotvec())
    return DemonstratedShape(
        position=learn_primitive(time, [position for position, _ in paths], POSITION_SPREAD),
        rotation=learn_primitive(time, turns, ROTATION_SPREAD),
    )


def _demonstrated(
    model: ActionModel,
    sketch: DemonstrationSketch,
    role: str,
    affordances: tuple[str, ...],
    time: Float[np.ndarray, " samples"],
) -> tuple[Float[np.ndarray, "samples 3"], Rotation] | None:
    """Path of the acting point, and rotations from the start, at times of the model; None if not kept."""
    path = next((path for path in sketch.paths if path.role == role), None)
    player = next((player for player in sketch.roles if player.role == role), None)
    if path is None or player is None or player.start is None or not set(affordances) <= set(player.affordances):
        return None
    kinds, roles = tuple(a.kind for a in model.anchors), tuple(a.role for a in model.anchors)
    times = np.array([anchor.time for anchor in model.anchors])
    own = locate_anchors(kinds, roles, times, sketch.events, sketch.duration)
    position, rotation = path.at(warp(time, times, own), sketch.duration)
    point = np.mean([player.start[player.affordances.index(name)] for name in affordances], axis=0) - path.position[0]
    return position + rotation.apply(point), rotation
