"""Bind a model to a scene: which object plays which role, where it starts and where it shall end."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.demonstrations.demonstration import Hand
from sbam.errors import BindingError
from sbam.learning.model import ActionModel
from sbam.learning.roles import bind_roles
from sbam.planning.task import MovedObject, Task
from sbam.scene import Scene, is_support

SUPPORT_TOLERANCE = 0.015  # m: a lowest region this near to a support stands on it
LYING = np.deg2rad(45.0)  # an object whose regions are connected by a vector flatter than this lies


def bind(model: ActionModel, scene: Scene, roles: Mapping[str, str] | None = None) -> Task:
    """Bind a model's roles to a scene's objects and find out what shall be moved from where to where.

    Args:
        model: the action model.
        scene: the scene.
        roles: role -> object name, where the choice shall not be left to the affordances.

    Raises:
        BindingError: if a role finds no object, or more than one that fit equally well, or if one hand holds several.
    """
    binding = bind_roles(model.roles, scene.objects, chosen=roles)
    T_agent_world = scene.T_world_agent.inv()
    poses = {name: T_agent_world * pose for name, pose in scene.T_world_object.items()}
    task = Task(model, scene, binding, poses, ())
    moved = []
    for role in model.roles:
        holds = sorted((hold for hold in model.holds if hold.role == role.name), key=lambda hold: hold.hand)
        if not role.moves or not holds:
            continue
        grasp, release = min(hold.grasp for hold in holds), max(hold.release for hold in holds)
        lifts = [anchor.time for anchor in model.anchors if anchor.kind == "lift" and anchor.role == role.name]
        places = [anchor.time for anchor in model.anchors if anchor.kind == "place" and anchor.role == role.name]
        lift, place = min(lifts, default=grasp), max(places, default=release)
        name = binding[role.name]
        moved.append(
            MovedObject(
                role=role.name,
                name=name,
                model=scene.objects[name],
                hands=tuple(hold.hand for hold in holds),
                start=poses[name],
                put_down=_put_down(task, role.name),
                lift=lift,
                place=place,
                grasp=min(grasp, lift),
                release=max(release, place),
                human_grasps={hold.hand: hold.hand_position for hold in holds},
            )
        )
    holder: dict[Hand, str] = {}
    for item in moved:
        for hand in item.hands:
            if hand in holder:
                raise BindingError(
                    f"the {hand} hand holds {holder[hand]!r} and {item.role!r} in this action, but may hold one object "
                    "per action: learn them as two actions"
                )
            holder[hand] = item.role
    return replace(task, moved=tuple(moved))


def _put_down(task: Task, role: str) -> RigidTransform:
    """Where an object ends: as far from its start as in the demonstrations, standing or lying as it did.

    The displacement is the mean of the role's own-start pairs at the end, when everything rests; a model without them
    (mode ``paper``) says nothing about it, and the object goes back to where it was.
    """
    start = task.T_agent_object[task.binding[role]]
    changes = [c for c in task.model.changes if c.pair.is_own_start and c.pair.first.role == role]
    if not changes:
        return start
    before = np.array([task.region_at_start(change.pair.first) for change in changes])
    after = before + np.array([change.at(np.array([task.model.duration]))[0][0] for change in changes])
    supported = _is_supported(task, role) and bool(abs((after - before)[:, 2].mean()) < 2 * SUPPORT_TOLERANCE)
    turn = _turn(before, after, about_vertical=supported)
    # What stands is put down where it stands; what ends in the air has no such place, all its regions count alike.
    kept = before[:, 2] < before[:, 2].min() + SUPPORT_TOLERANCE if supported else np.full(len(before), True)
    position = after[kept].mean(axis=0) + turn.apply(start.translation - before[kept].mean(axis=0))
    if supported:
        position[2] = start.translation[2]
    return RigidTransform.from_components(position, turn * start.rotation)


def _turn(
    before: Float[np.ndarray, "regions 3"], after: Float[np.ndarray, "regions 3"], about_vertical: bool
) -> Rotation:
    """The smallest rotation that turns the line through an object's regions; of a standing object nothing is known."""
    if len(before) < 2:
        return Rotation.identity()
    first, second = before[-1] - before[0], after[-1] - after[0]
    if about_vertical:
        if np.hypot(*first[:2]) < np.linalg.norm(first) * np.cos(LYING):
            return Rotation.identity()
        first, second = first * [1.0, 1.0, 0.0], second * [1.0, 1.0, 0.0]
    axis = np.cross(first, second)
    length = float(np.linalg.norm(axis))
    if length < 1e-9:
        return Rotation.identity()
    return Rotation.from_rotvec(np.arctan2(length, first @ second) * axis / length)


def _is_supported(task: Task, role: str) -> bool:
    """Whether the object stands at the start on a region of another object that things are placed onto."""
    name = task.binding[role]
    model, pose = task.scene.objects[name], task.T_agent_object[name]
    lowest = min(float(pose.apply(region.center)[2]) for region in model.affordance_regions)
    radius = min((region.half_axes.min() for region in model.affordance_regions), default=0.0)
    for other, support in task.scene.objects.items():
        for region in support.affordance_regions:
            if other != name and is_support(region.affordance):
                height = float(task.T_agent_object[other].apply(region.center)[2])
                if abs(lowest - height) < SUPPORT_TOLERANCE + (
                    radius + 0.03 if "place" not in model.affordances else 0.0
                ):
                    return True
    return False
