"""Dense paths of the moved objects between the optimised keypoints.

Joints must not simply be interpolated between keypoints (hands stray by centimetres and two-handed grasps open).
What is wanted is interpolated instead: the position of the region that acts (the spout, the rim, the axis of the pin)
and the orientation of its object. Positions follow monotone cubics (PCHIP), which come to rest at turning points and
never overshoot a keypoint: rounding the corners of straight lines instead took a sixth of the strokes of a rolling pin.
Rounding cuts turning points even so, by 5 % of a stroke a second long; what it cuts off is added beforehand.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.interpolate import pchip_interpolate
from scipy.ndimage import gaussian_filter1d
from scipy.spatial.transform import RigidTransform, Rotation, Slerp

from sbam.planning.motion.demonstrated_shape import DemonstratedShape, demonstrated_shapes
from sbam.planning.task import MovedObject, Task

SMOOTHING = 0.05  # s: standard deviation of the Gaussian that rounds the corners at keypoints
EASING = 0.20  # s after the lift and before the place over which rounding fades out, so that objects rest exactly


@dataclass(frozen=True)
class ObjectPath:
    """Dense pose of one moved object.

    Attributes:
        role: its role.
        model_time: uniform, s.
        pose: poses in the agent frame.
    """

    role: str
    model_time: Float[np.ndarray, " ticks"]
    pose: RigidTransform


def acting_point(task: Task, moved: MovedObject) -> Float[np.ndarray, " 3"]:
    """The point whose path matters most, in the object's frame, m: the mean centre of `acting_affordances`."""
    centers = [moved.model.region(affordance).center for affordance in acting_affordances(task, moved)]
    return np.mean(centers, axis=0)


def acting_affordances(task: Task, moved: MovedObject) -> tuple[str, ...]:
    """The affordances of the regions of an object whose path matters most, sorted.

    They are those that are watched against another object: against a moved one where there is such a
    pair (spout against rim), else against any (handles against the table), else of all regions of the object.
    """
    roles = {other.role for other in task.moved}
    cross = [
        change.pair for change in task.model.changes if moved.role in change.pair.roles and len(change.pair.roles) == 2
    ]
    functional = [pair for pair in cross if set(pair.roles) <= roles]
    references = {
        reference
        for pair in (functional or cross)
        for reference in (pair.first, pair.second)
        if reference is not None and reference.role == moved.role
    }
    if functional and len({reference.affordance for reference in references}) > 1:
        # All pairs are watched (mode `paper`): those that name what the object is for, not where it stands.
        references = {r for r in references if r.affordance != "place"} or references
    return tuple(sorted(reference.affordance for reference in references)) or moved.model.affordances


def shapes_of(task: Task) -> dict[str, DemonstratedShape]:
    """Role -> how its object moved in the demonstrations, for those of which the model has kept it."""
    return demonstrated_shapes(task, {moved.role: acting_affordances(task, moved) for moved in task.moved})


def object_path(
    task: Task,
    moved: MovedObject,
    keypoint_times: Float[np.ndarray, " keypoints"],
    keypoint_poses: RigidTransform,
    time: Float[np.ndarray, " ticks"],
    shape: DemonstratedShape | None = None,
) -> ObjectPath:
    """Interpolate an object's keypoint poses; before its lift and after its place it rests exactly.

    Args:
        task: model bound to a scene.
        moved: the object.
        keypoint_times: on the model's time axis, s.
        keypoint_poses: poses at the keypoints, agent frame.
        time: uniform grid on the model's time axis, s; may reach beyond the keypoints.
        shape: how the object moved in the demonstrations, to be kept between the keypoints.

    Returns:
        The dense path.
    """
    first, last = np.searchsorted(keypoint_times, [moved.lift + 1e-6, moved.place - 1e-6])
    inside = slice(int(first), int(last))
    times = np.concatenate([[moved.lift], keypoint_times[inside], [moved.place]])
    point = acting_point(task, moved)
    rotations = Rotation.concatenate(
        [moved.start.rotation, keypoint_poses.rotation[inside], moved.put_down.rotation]
        if last > first
        else [moved.start.rotation, moved.put_down.rotation]
    )
    points = np.concatenate(
        [moved.start.apply(point)[None], keypoint_poses.apply(point)[inside], moved.put_down.apply(point)[None]]
    )
    clipped = np.clip(time, moved.lift, moved.place)
    rotation = Slerp(times, rotations)(clipped)
    fade = ease(np.minimum(time - moved.lift, moved.place - time) / EASING)
    width = SMOOTHING / float(time[1] - time[0])
    if shape is not None:
        aside = shape.rotation.through(times, np.zeros((len(times), 3)), clipped)
        rotation = rotation * Rotation.from_rotvec(aside)

    def rounded(via: Float[np.ndarray, "points 3"]) -> Float[np.ndarray, "ticks 3"]:
        path = shape.position.through(times, via, clipped) if shape else pchip_interpolate(times, via, clipped)
        return gaussian_filter1d(path, width, axis=0, mode="nearest")

    smooth_position = rounded(points)
    cut_off = points - np.stack([np.interp(times, time, axis) for axis in smooth_position.T], axis=-1)
    cut_off[[0, -1]] = 0.0  # where objects rest exactly all the same
    smooth_position = rounded(points + cut_off)
    smooth_rotation = _smooth_rotations(rotation, width)
    # Before the middle of the motion rest means the start, after it the put-down.
    early = time < 0.5 * (moved.lift + moved.place)
    rest_position = np.where(early[:, None], points[0], points[-1])
    position = rest_position + fade[:, None] * (smooth_position - rest_position)
    rest_rotation = Rotation.from_quat(
        np.where(early[:, None], moved.start.rotation.as_quat(), moved.put_down.rotation.as_quat())
    )
    away = (smooth_rotation * rest_rotation.inv()).as_rotvec()
    rotation = Rotation.from_rotvec(fade[:, None] * away) * rest_rotation
    return ObjectPath(moved.role, time, RigidTransform.from_components(position - rotation.apply(point), rotation))


def ease(share: Float[np.ndarray, "*batch"]) -> Float[np.ndarray, "*batch"]:
    """Quintic from 0 at 0 to 1 at 1 with zero velocity and acceleration at both ends; clipped outside."""
    s = np.clip(share, 0.0, 1.0)
    return s**3 * (10.0 + s * (-15.0 + 6.0 * s))


def _smooth_rotations(rotation: Rotation, width: float) -> Rotation:
    """Gaussian mean of neighbouring rotations, as of quaternions with continuous signs: exact to third order."""
    quaternion_xyzw = rotation.as_quat()
    flips = np.cumprod(np.where((quaternion_xyzw[1:] * quaternion_xyzw[:-1]).sum(axis=1) < 0, -1.0, 1.0))
    quaternion_xyzw[1:] *= flips[:, None]
    return Rotation.from_quat(gaussian_filter1d(quaternion_xyzw, width, axis=0, mode="nearest"))
