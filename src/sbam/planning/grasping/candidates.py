"""Grasps: where a robot's hand can hold an object.

Azimuths and heights of people transfer to robots, the pitch of the hand does not (a person's forearm comes from below
the hand, a robot's would be in the table), so candidates are made around the object's grasp regions and people's grasps
only rank them.

A gripper's fingers close on two sides of the object; a hand with a palm lays it flat against the object, its stretched
fingers beside it, and closes them around it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.demonstrations.demonstration import Hand
from sbam.errors import UnreachableError
from sbam.planning.task import MovedObject
from sbam.robots import ObjectHand, Robot
from sbam.robots.collision import CollisionModel
from sbam.robots.collision_pairs import hand_bodies
from sbam.scene import GraspRegion

AZIMUTHS = np.deg2rad(np.arange(-180.0, 180.0, 30.0))  # 0: approach forward, + turns to the left
TILTS_AROUND = np.deg2rad([0.0, 15.0, 30.0, 45.0, 60.0])  # fingers point down by this
TILTS_ACROSS = np.deg2rad([0.0, 20.0, 40.0, 60.0])  # approach from above, leaning forward by this
TILTS_PALM_DOWN = np.deg2rad([0.0, 15.0, 30.0, 45.0])  # palm down on a bar, fingers forward and down by this
HEIGHTS = (0.5, 0.0, -0.5)  # along the region's axis, shares of its half length
PALM_HEIGHTS = (1.0, 0.5, 0.0)  # the same for palms on vessels: a palm is wide and the table near
DEPTHS = (0.0, 0.006, 0.012, 0.018)  # m that the TCP may stay short of the axis so that only fingers touch the object
PALM_DEPTHS = tuple(0.002 * i for i in range(5, 46))  # m that it stays short where a palm lies against the object
LAID_ON = 0.010  # m that a palm may lie farther from the axis than where it lies nearest
ALONG_AXIS = 0.2  # sine of the angle below which a direction counts as along an axis and leads to no grasp
PALM_CLEARANCE = 0.002  # m between the palm and what the fingers hold


@dataclass(frozen=True)
class Grasp:
    """A rigid hold of an object by one hand.

    Attributes:
        role: role of the object.
        hand: the arm that holds it.
        region: name of the object's grasp region.
        T_object_tcp: pose of the tool centre point (TCP) in the object's frame.
        azimuth: direction of approach about the vertical at the start, 0 forward, positive to the left, rad.
        depth: how far the TCP stays short of the region's axis, so that the palm does not touch, m.
        tilt: how far a gripper's approach points down (vessels) or leans forward from vertical (bars); how far the
            fingers of a hand with a palm point down; rad.
        flipped: whether a gripper is turned by half a turn about its approach.
        width: opening of the fingers when they hold, m.
        human_distance: angle to the nearest demonstrated azimuth, rad; 0 where none was observed.
    """

    role: str
    hand: Hand
    region: str
    T_object_tcp: RigidTransform
    azimuth: float
    depth: float
    tilt: float
    flipped: bool
    width: float
    human_distance: float


def candidate_grasps(robot: Robot, collision: CollisionModel, moved: MovedObject, hand: Hand) -> tuple[Grasp, ...]:
    """All grasps of an object that fit one hand: between its fingers, and clear of its palm; in no order.

    Args:
        robot: the robot.
        collision: shapes of the robot and the scene's objects.
        moved: the object, standing at its start.
        hand: the hand.

    Raises:
        UnreachableError: if the object has no grasp region that fits the hand, or none without touching the palm.
    """
    opening = robot.arms[hand].hand.max_width
    regions = _regions_for(moved, hand)
    fitting = [region for region in regions if region.width <= opening]
    if not fitting:
        sizes = ", ".join(f"{region.name!r} ({1e3 * region.width:.0f} mm)" for region in regions) or "none"
        raise UnreachableError(
            f"object {moved.name!r} has no grasp region that fits {robot.name}'s {hand} hand "
            f"(opens {1e3 * opening:.0f} mm): {sizes}"
        )
    grasps = [grasp for region in fitting for grasp in _at_region(robot, collision, moved, hand, region)]
    if not grasps:
        raise UnreachableError(
            f"{robot.name}'s {hand} hand finds no grasp of {moved.name!r} as it stands or lies: "
            "its palm would touch the object, or its region is upright where it should lie"
        )
    return tuple(grasps)


def _regions_for(moved: MovedObject, hand: Hand) -> list[GraspRegion]:
    """The object's grasp regions; of regions named after hands only the one for this hand."""
    named = [region for region in moved.model.grasp_regions if hand in region.name.split()]
    return named or [r for r in moved.model.grasp_regions if not {"left", "right"} & set(r.name.split())]


def _at_region(
    robot: Robot, collision: CollisionModel, moved: MovedObject, hand: Hand, region: GraspRegion
) -> list[Grasp]:
    has_palm = robot.arms[hand].hand.has_palm
    axis = moved.start.rotation.apply(region.axis)
    directions = _palm_directions(moved, hand, region, axis) if has_palm else _directions(moved, region, axis)
    if not directions:
        return []
    azimuth, tilt = np.array([row[0] for row in directions]), np.array([row[1] for row in directions])
    approach, across = np.array([row[2] for row in directions]), np.array([row[3] for row in directions])
    rotation = _tcp_rotations(robot, hand, approach, across)
    heights = HEIGHTS if region.kind == "around" or has_palm else (0.0,)
    heights = np.array(PALM_HEIGHTS if region.kind == "around" and has_palm else heights)
    centers = moved.start.apply(region.center + heights[:, None] * region.half_length * region.axis)
    # Round objects and faces look alike from every azimuth: one direction for each tilt will do.
    tilts, first, alike = np.unique(tilt, return_index=True, return_inverse=True)
    at = np.repeat(centers, len(tilts), axis=0), np.tile(first, len(centers))
    depths = _depths(robot, collision, moved, hand, at[0], approach[at[1]], rotation[at[1]])
    depth = depths.reshape(len(centers), len(tilts))[:, alike]  # (heights, directions)
    turns = rotation[:, None] if has_palm else np.stack([rotation, _tcp_rotations(robot, hand, approach, -across)], 1)
    height, direction, flipped = np.nonzero(
        np.broadcast_to(np.isfinite(depth)[..., None], (*depth.shape, turns.shape[1]))
    )
    found = depth[height, direction]
    T_agent_tcp = RigidTransform.from_components(
        centers[height] - found[:, None] * approach[direction], Rotation.from_matrix(turns[direction, flipped])
    )
    T_object_tcp = list(moved.start.inv() * T_agent_tcp)
    human = _human_azimuths(moved, hand, region)
    distance = np.abs(_wrap(azimuth[:, None] - human)).min(axis=1) if len(human) else np.zeros(len(azimuth))
    # Where something keeps a palm away from the region the fingers would close around nothing.
    farthest = found.min(initial=np.inf) + LAID_ON if has_palm else np.inf
    return [
        Grasp(
            role=moved.role,
            hand=hand,
            region=region.name,
            T_object_tcp=T_object_tcp[i],
            azimuth=float(azimuth[direction[i]]),
            depth=float(found[i]),
            tilt=float(tilt[direction[i]]),
            flipped=bool(flipped[i]),
            width=region.width,
            human_distance=float(distance[direction[i]]),
        )
        for i in np.flatnonzero(found <= farthest)
    ]


def _depths(
    robot: Robot,
    collision: CollisionModel,
    moved: MovedObject,
    hand: Hand,
    center: Float[np.ndarray, "poses 3"],
    approach: Float[np.ndarray, "poses 3"],
    rotation: Float[np.ndarray, "poses 3 3"],
) -> Float[np.ndarray, " poses"]:
    """How far the TCP must stay short of the axis so that only fingers touch the object; infinite if no depth will do.

    Of a hand with a palm nothing may reach into the object: its fingers are stretched.

    Args:
        robot: the robot.
        collision: shapes of the robot and the scene's objects.
        moved: the object, standing at its start.
        hand: the hand.
        center: on the axis, agent frame, m.
        approach: directions of approach.
        rotation: orientations of the TCP.

    Returns:
        The distances, m.
    """
    has_palm = robot.arms[hand].hand.has_palm
    depths = np.array(PALM_DEPTHS if has_palm else DEPTHS)
    home = robot.clip(robot.home)
    frame = robot.kinematics(home[None], [robot.arms[hand].tcp_frame])
    T_agent_home = RigidTransform.from_components(frame.position[0, 0], Rotation.from_matrix(frame.rotation[0, 0]))
    samples = len(center) * len(depths)
    T_agent_tcp = RigidTransform.from_components(
        (center[:, None] - depths[:, None] * approach[:, None]).reshape(samples, 3),
        Rotation.from_matrix(np.repeat(rotation, len(depths), axis=0)),
    )
    # The arm stays at home and the object comes to the hand, everything else far away.
    away = RigidTransform.from_translation([0.0, 0.0, -100.0])
    objects = dict.fromkeys(collision.shapes.objects, away)
    objects[moved.name] = T_agent_home * T_agent_tcp.inv() * moved.start
    held = {ObjectHand(moved.name, hand): np.full(samples, not has_palm, dtype=bool)}
    near = collision.near(
        np.tile(home, (samples, 1)), objects, held, PALM_CLEARANCE, classes=("arm-object", "palm-object")
    )
    own = set(hand_bodies(robot, hand))
    touching = np.zeros(samples, dtype=bool)
    for sample, first, second in zip(near.sample, near.first, near.second, strict=True):
        touching[sample] |= moved.name in (first, second) and bool(own & {first, second})
    return np.where(touching, np.inf, np.tile(depths, len(center))).reshape(len(center), -1).min(axis=1)


def _directions(
    moved: MovedObject, region: GraspRegion, axis: Float[np.ndarray, " 3"]
) -> list[tuple[float, float, Float[np.ndarray, " 3"], Float[np.ndarray, " 3"]]]:
    """(azimuth, tilt, approach, opening direction) of all candidates at a region, agent frame."""
    directions = []
    if region.kind == "around":
        for azimuth in _azimuths(moved, region, axis):
            outward = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
            outward -= axis * (outward @ axis)
            length = np.linalg.norm(outward)
            if length < ALONG_AXIS:
                continue
            outward /= length
            for tilt in TILTS_AROUND:
                directions.append(
                    (azimuth, tilt, np.cos(tilt) * outward - np.sin(tilt) * axis, np.cross(axis, outward))
                )
        return directions
    forward = np.cross(np.array([0.0, 0.0, 1.0]), axis)
    length = np.linalg.norm(forward)
    if length < ALONG_AXIS:
        return []
    forward *= np.copysign(1.0, forward[1]) / length
    azimuth = float(np.arctan2(-forward[0], forward[1]))
    for tilt in TILTS_ACROSS:
        approach = np.array([0.0, 0.0, -np.cos(tilt)]) + np.sin(tilt) * forward
        approach -= axis * (approach @ axis)
        approach /= np.linalg.norm(approach)
        directions.append((azimuth, tilt, approach, np.cross(approach, axis)))
    return directions


def _palm_directions(
    moved: MovedObject, hand: Hand, region: GraspRegion, axis: Float[np.ndarray, " 3"]
) -> list[tuple[float, float, Float[np.ndarray, " 3"], Float[np.ndarray, " 3"]]]:
    """(azimuth, tilt, palm's normal, fingers' direction) of all candidates at a region, agent frame.

    Vessels are held with the thumb up; tilting turns the hand about the palm's normal until the fingers point down.
    Bars are held with the palm down and the thumbs inwards; tilting lowers the fingers and raises the wrist.
    """
    directions = []
    if region.kind == "around":
        for azimuth in _azimuths(moved, region, axis):
            normal = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
            normal -= axis * (normal @ axis)
            length = np.linalg.norm(normal)
            if length < ALONG_AXIS:
                continue
            normal /= length
            level = np.cross(axis, normal) if hand == "left" else np.cross(normal, axis)
            for tilt in TILTS_AROUND:
                directions.append((azimuth, tilt, normal, np.cos(tilt) * level - np.sin(tilt) * axis))
        return directions
    up = np.array([0.0, 0.0, 1.0])
    forward = np.cross(up, axis)
    length = np.linalg.norm(forward)
    if length < ALONG_AXIS:
        return []
    forward *= np.copysign(1.0, forward[1]) / length
    up -= axis * (up @ axis)
    up /= np.linalg.norm(up)
    azimuth = float(np.arctan2(-forward[0], forward[1]))
    for tilt in TILTS_PALM_DOWN:
        normal = -np.cos(tilt) * up - np.sin(tilt) * forward
        directions.append((azimuth, tilt, normal, np.cos(tilt) * forward - np.sin(tilt) * up))
    return directions


def _azimuths(moved: MovedObject, region: GraspRegion, axis: Float[np.ndarray, " 3"]) -> Float[np.ndarray, " azimuths"]:
    """Azimuths of approach: any for round objects, towards the faces for the others."""
    if region.faces == 0:
        return AZIMUTHS
    side = np.cross(region.axis, np.eye(3)[np.argmin(np.abs(region.axis))])
    normal = moved.start.rotation.apply(side / np.linalg.norm(side))
    first = np.arctan2(-normal[0], normal[1])
    return _wrap(first + 2 * np.pi * np.arange(region.faces) / region.faces)


def _tcp_rotations(
    robot: Robot, hand: Hand, approach: Float[np.ndarray, "directions 3"], opening: Float[np.ndarray, "directions 3"]
) -> Float[np.ndarray, "directions 3 3"]:
    """Orientations of a TCP whose approach and opening directions point as wanted."""
    description = robot.arms[hand].hand
    own_approach, own_opening = np.array(description.approach), np.array(description.across)
    own = np.column_stack([np.cross(own_opening, own_approach), own_opening, own_approach])
    wanted = np.stack([np.cross(opening, approach), opening, approach], axis=-1)
    return wanted @ own.T


def _human_azimuths(moved: MovedObject, hand: Hand, region: GraspRegion) -> Float[np.ndarray, " demonstrations"]:
    """Azimuths from which people held the object: from their hand towards the region's axis."""
    positions = moved.human_grasps.get(hand, np.zeros((0, 3)))
    if region.kind != "around" or len(positions) == 0:
        return np.zeros(0)
    towards = moved.start.rotation.apply(region.center) - positions
    return np.arctan2(-towards[:, 0], towards[:, 1])


def _wrap(angle: Float[np.ndarray, "*angles"]) -> Float[np.ndarray, "*angles"]:
    return (angle + np.pi) % (2 * np.pi) - np.pi
