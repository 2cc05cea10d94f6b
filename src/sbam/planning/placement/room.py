"""Whether there is room for a robot's base, and for objects on what they stand on."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float
from scipy.spatial.transform import RigidTransform

from sbam.planning.task import Task
from sbam.robots import Robot
from sbam.robots.collision_shapes import CollisionShapes

MAY_OVERLAP = 0.01  # m: a base that is mounted on a table touches it
EDGE = 0.03  # m that an object's origin keeps from the edge of what it stands on


def has_room(robot: Robot, task: Task, T_agent_base: RigidTransform) -> Bool[np.ndarray, " bases"]:
    """Whether what no planned joint moves keeps clear of furniture and objects, for poses of the base.

    Args:
        robot: the robot; where it stands is of no account.
        task: model bound to a scene.
        T_agent_base: poses of its frame in the agent frame.
    """
    import mujoco

    at_origin = robot.placed(RigidTransform.identity())
    shapes = CollisionShapes(at_origin, task.scene.objects)
    T_base_agent = T_agent_base.inv()
    objects = {name: T_base_agent * pose for name, pose in task.T_agent_object.items()}
    home = np.tile(robot.clip(robot.home), (len(T_agent_base), 1))
    position, rotation = shapes.poses(home, objects)
    standing = [name for name in shapes.robot_bodies if not robot.frame_joints(name).any()]
    owners = [shapes.owners[index] for index in shapes.owner]
    first = [i for i, owner in enumerate(owners) if owner in standing]
    second = [i for i, owner in enumerate(owners) if owner in task.T_agent_object]
    data = mujoco.MjData(shapes.model)
    room = np.ones(len(home), dtype=bool)
    for base in range(len(home)):
        data.geom_xpos[shapes.geoms] = position[base]
        data.geom_xmat[shapes.geoms] = rotation[base].reshape(-1, 9)
        room[base] = all(
            mujoco.mj_geomDistance(shapes.model, data, shapes.geoms[i], shapes.geoms[j], 0.0, None) > -MAY_OVERLAP
            for i in first
            for j in second
        )
    return room


def stay_on_their_supports(task: Task, shifts: Float[np.ndarray, "moves 2"]) -> Bool[np.ndarray, " moves"]:
    """Whether all movable objects that stand over a box of furniture still do when moved by shifts, m."""
    stay = np.ones(len(shifts), dtype=bool)
    for name, model in task.scene.objects.items():
        if not model.movable:
            continue
        at = task.T_agent_object[name].translation
        after = np.column_stack([at[:2] + shifts, np.full(len(shifts), at[2])])
        for support, furniture in task.scene.objects.items():
            if furniture.movable:
                continue
            for primitive in furniture.geometry:
                if primitive.kind != "box":
                    continue
                pose = task.T_agent_object[support] * primitive.T_object_primitive
                if _over(pose, primitive.size, at[None], 0.0)[0]:
                    stay &= _over(pose, primitive.size, after, EDGE)
    return stay


def _over(
    pose: RigidTransform, size: Float[np.ndarray, " 3"], points: Float[np.ndarray, "points 3"], edge: float
) -> Bool[np.ndarray, " points"]:
    """Which points are vertically over a box, seen in its own frame."""
    local = pose.inv().apply(points)
    up = int(np.argmax(np.abs(pose.rotation.as_matrix()[2])))
    across = [axis for axis in range(3) if axis != up]
    return (np.abs(local[:, across]) <= np.maximum(np.asarray(size)[across] - edge, 0.0)).all(axis=1)
