"""Look at a robot before anything is planned with it: what is there, what is missing, what looks wrong."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import RigidTransform

from sbam.robots.collision import CollisionModel
from sbam.robots.collision_pairs import hand_bodies
from sbam.robots.model_files import find_model, read_model
from sbam.robots.report import finite
from sbam.robots.robot import Robot
from sbam.robots.urdf import links_without_inertia, urdf_joints

SAMPLES = 5000
LENGTH_OFF = 0.03  # share by which a stated arm length may differ from the sampled one
TABLE_ZONE = np.array([[-0.3, 0.25, 0.0], [0.3, 0.6, 0.4]])  # m, agent frame: where things are done on a table
NEAR_LIMIT = 0.01  # rad: a home posture nearer to a limit is worth a word


def check_robot(robot: Robot) -> dict[str, Any]:
    """What there is to say about a robot, as plain numbers and words; keys: docs, "Reports".

    ``problems`` stop plans or make them wrong; ``warnings`` should be looked at.
    """
    description = robot.description
    files, warnings = _files(robot)
    problems: list[str] = []
    arms = {}
    generator = np.random.default_rng(0)
    low = np.where(np.isfinite(robot.lower), robot.lower, -np.pi)
    high = np.where(np.isfinite(robot.upper), robot.upper, np.pi)
    q = generator.uniform(low, high, (SAMPLES, len(low)))
    robot = robot.placed_for(RigidTransform.identity())
    home = robot.clip(robot.home)[None]
    for side, arm in robot.arms.items():
        frames = [arm.tcp_frame, arm.shoulder_frame]
        tcp, shoulder = robot.kinematics(q, frames).position.swapaxes(0, 1)
        reach = float(np.linalg.norm(tcp - shoulder, axis=1).max())
        share = float(((tcp > TABLE_ZONE[0]) & (tcp < TABLE_ZONE[1])).all(axis=1).mean())
        at_home = robot.kinematics(home, frames)
        approach = at_home.rotation[0, 0] @ np.array(arm.hand.approach)
        arms[side] = {
            "joints": [robot.joint_names[i] for i in arm.joint_indices],
            "tcp": arm.tcp_frame,
            "shoulder": arm.shoulder_frame,
            "elbow": arm.elbow_frame,
            "wrist": arm.wrist_frame,
            "hand": list(hand_bodies(robot, side)),
            "grip": "palm" if arm.hand.has_palm else "gripper",
            "max_width": arm.hand.max_width,
            "length": arm.length,
            "sampled_reach": reach,
            "shoulder_at_home": at_home.position[0, 1].tolist(),
            "tcp_at_home": at_home.position[0, 0].tolist(),
            "approach_at_home": approach.tolist(),
            "postures_over_table": share,
        }
        if abs(reach - arm.length) > LENGTH_OFF * arm.length:
            warnings.append(
                f"{side} arm: length is {arm.length:g} m, but TCP and shoulder are up to {reach:.3f} m apart"
            )
        if not share:
            problems.append(f"{side} arm: none of {SAMPLES} postures has its TCP over the table; see base_in_agent")
        if at_home.position[0, 0, 2] < 0:
            warnings.append(f"{side} arm: at home the TCP is below the table top")
    for name, room in zip(robot.joint_names, np.minimum(home - robot.lower, robot.upper - home)[0], strict=True):
        if room < NEAR_LIMIT:
            warnings.append(f"joint {name!r} is at its limit at home")
    problems += _touching(robot, home)
    left, right = (arms[side]["tcp_at_home"][0] for side in ("left", "right"))
    if left > right:
        problems.append("the left hand is at the right of the right one; turn the robot in parts or base_in_agent")
    return {
        "name": robot.name,
        "file": description.path,
        "note": description.note,
        "models": files,
        "joints": _joints(robot),
        "locked_joints": dict(_held(robot)),
        "arms": arms,
        "problems": problems,
        "warnings": warnings,
    }


def _joints(robot: Robot) -> list[dict[str, Any]]:
    owner = {int(column): side for side, arm in robot.arms.items() for column in arm.joint_indices}
    lower, upper = finite(robot.lower), finite(robot.upper)
    return [
        {
            "name": name,
            "arm": owner.get(i, "torso"),
            "kind": "slide" if robot.is_prismatic[i] else "continuous" if robot.is_continuous[i] else "hinge",
            "lower": lower[i],
            "upper": upper[i],
            "home": float(robot.home[i]),
            "velocity": float(robot.velocity_limit[i]),
            "acceleration": float(robot.acceleration_limit[i]),
            "jerk": float(robot.jerk_limit[i]),
            "torque": float(robot.torque_limit[i]),
        }
        for i, name in enumerate(robot.joint_names)
    ]


def _held(robot: Robot) -> dict[str, float]:
    """Every joint that is not planned, and where it is held."""
    spec = robot.spec(lock=False)
    given = robot.description.locked_joints
    names = [joint.name for joint in spec.joints if joint.name not in robot.description.joints]
    return {name: given.get(name, 0.0) for name in names}


def _files(robot: Robot) -> tuple[list[dict[str, Any]], list[str]]:
    """The model files, and what is missing in them."""
    description = robot.description
    files, warnings = [], []
    for index, part in enumerate(description.parts):
        path = find_model(part.model, description.path, f"$.parts[{index}].model")
        read = read_model(path)
        is_urdf = path.suffix == ".urdf"
        mimics = {name: joint.mimics for name, joint in urdf_joints(path).items() if joint.mimics} if is_urdf else {}
        light = links_without_inertia(path) if is_urdf else []
        known = {str(file["path"]) for file in files}
        files.append(
            {
                "path": str(path),
                "prefix": part.prefix,
                "missing_meshes": list(read.missing_meshes),
                "links_with_capsules_instead": list(read.stand_ins),
                "mimic_joints": mimics,
                "links_without_inertia": light,
            }
        )
        if str(path) in known:
            continue
        name = Path(path).name
        if read.missing_meshes:
            warnings.append(f"{name}: {len(read.missing_meshes)} meshes are not found or not STL, OBJ or MSH")
        if read.stand_ins:
            warnings.append(f"{name}: {len(read.stand_ins)} links have no primitives to collide with and get capsules")
        if mimics:
            warnings.append(f"{name}: mimic joints are held still: {', '.join(mimics)}")
        if light:
            warnings.append(f"{name}: links that move have no inertia, torques are too small: {', '.join(light)}")
    return files, warnings


def _touching(robot: Robot, home: Any) -> list[str]:
    """What overlaps at home."""
    near = CollisionModel(robot, {}).near(home, {}, margin=0.0)
    pairs = sorted({tuple(sorted(pair)) for pair in zip(near.first, near.second, strict=True)})
    return [f"{first!r} and {second!r} overlap at home; another home, or may_touch" for first, second in pairs]
