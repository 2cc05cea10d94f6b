"""Write a commented description for a robot of which only a model file is there."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from sbam.errors import FileFormatError
from sbam.files import write_atomically
from sbam.robots.collision import CollisionModel
from sbam.robots.description import FORMAT_VERSION, ArmName, RobotDescription, check_description
from sbam.robots.guess import GuessedArm, GuessedArms, guess_arms
from sbam.robots.model_files import find_model
from sbam.robots.robot import Robot
from sbam.robots.urdf import UrdfJoint, urdf_joints

Floats = NDArray[np.float64]

VELOCITY, ACCELERATION, JERK, TORQUE = 1.5, 5.0, 500.0, 100.0  # assumed where the model says nothing
SLOWEST = 1e-3  # rad/s: limits below this are placeholders
ARM_SPACING = 0.8  # share of the arm's length between the bases of a single arm that is mounted twice
WORK_AHEAD = 0.45  # m before the agent where objects usually stand
WORK_REACH = 0.62  # share of the arm's length at which it works best
SHOULDER_HEIGHT = 0.40  # m above the table
STANDS_ON_FLOOR = 0.6  # m: shoulders higher than this above the robot's frame
SAMPLES, ROUNDS, ELITE = 600, 8, 30  # of the search for a home posture


def new_description(model: str, path: str | Path, name: str | None = None) -> tuple[RobotDescription, list[str]]:
    """Guess a description from a model and write it with comments.

    Args:
        model: MJCF or URDF file, or the name of a model of `robot_descriptions`.
        path: YAML file to write.
        name: of the robot; default that of the file.

    Returns:
        The description, and a sentence for each thing that was guessed or assumed and should be looked at.

    Raises:
        FileFormatError: if the model cannot be used or holds nothing like an arm.
        UnknownNameError: if `robot_descriptions` has no such model.
        OutputError: if the file cannot be written.
    """
    path = Path(path)
    if path.suffix not in (".yaml", ".yml"):
        raise FileFormatError(path, "", "a description is a YAML file", "a name that ends in .yaml")
    source = find_model(model, Path.cwd() / path.name)
    reference = model if model.endswith("_description") else os.path.relpath(source.resolve(), path.resolve().parent)
    arms = guess_arms(source)
    known = urdf_joints(source) if source.suffix == ".urdf" else {}
    content, notes = _content(arms, known, reference, name or path.stem)
    description = _description(content, path)
    robot = Robot(description, RigidTransform.identity())
    if turn := _turn_to_forward(robot):
        notes.append(f"the model does not look along x: it is turned by {turn} degrees")
        for part in content["parts"]:
            part["rotation_rpy_deg"] = [0, 0, turn]
        robot = Robot(_description(content, path), RigidTransform.identity())
    content = _measured(content, robot)
    touching = _touching(Robot(_description(content, path), RigidTransform.identity()))
    content["may_touch"] = touching
    description = _description(content, path)
    write_atomically(path, _yaml(content))
    return description, notes


def _description(content: Mapping[str, Any], path: Path) -> RobotDescription:
    description = msgspec.convert(content, RobotDescription)
    description = msgspec.structs.replace(description, path=str(path))
    check_description(description)
    return description


def _content(
    guess: GuessedArms, known: Mapping[str, UrdfJoint], reference: str, name: str
) -> tuple[dict[str, Any], list[str]]:
    """The description as plain values, before anything was measured on the model."""
    notes = []
    sides: tuple[ArmName, ...] = ("left", "right")
    prefix = {side: f"{side}_" if guess.is_single else "" for side in sides}
    parts: list[dict[str, Any]] = [{"model": reference}]
    if guess.is_single:
        notes.append("the model holds a single arm: it is mounted twice, side by side")
        parts = [{"model": reference, "prefix": prefix[side], "position": [0, 0, 0]} for side in sides]
    joints, locked, arms = {}, {}, {}
    assumed = []
    for side in sides:
        arm = guess.arms[side]
        for joint, rest in zip(arm.joints, arm.rest, strict=True):
            joints[prefix[side] + joint], missing = _joint(known.get(joint), rest)
            assumed += [f"{joint} {what}" for what in missing]
        for other, position in guess.others.items():
            locked[prefix[side] + other] = round(position, 5)
        arms[side] = _arm(arm, prefix[side])
    if assumed:
        notes.append(f"assumed, because the model does not say: {_listed(dict.fromkeys(assumed))}")
    notes.append(f"assumed for every joint: acceleration {ACCELERATION:g} rad/s^2, jerk {JERK:g} rad/s^3")
    if guess.above:
        notes.append(f"{', '.join(guess.above)} move both arms; they are held still (see torso_joints)")
    for side in sides:
        notes.append(f"{side} hand: TCP {arms[side]['tcp']}, approach and opening are guessed from its shape")
    return {
        "format_version": FORMAT_VERSION,
        "name": name,
        "note": "limits and frames guessed from the model file",
        "parts": parts,
        "base_in_agent": {"position": [0, 0, 0], "rotation_rpy_deg": [0, 0, 90]},
        "joints": joints,
        "locked_joints": locked,
        "torso_joints": [],
        "arms": arms,
        "human_likeness": False,
    }, notes


def _joint(known: UrdfJoint | None, rest: float) -> tuple[dict[str, float], list[str]]:
    """Limits of a joint, and what of them is assumed."""
    values: dict[str, float] = {"home": rest}
    missing = []
    lower, upper = (known.lower, known.upper) if known and known.kind != "continuous" else (-1.0, 1.0)
    if lower is None or upper is None or not np.isfinite([lower, upper]).all() or lower >= upper:
        values |= {"lower": -3.14159, "upper": 3.14159}
        missing.append("position limits")
    velocity, effort = (known.velocity, known.effort) if known else (None, None)
    if velocity is None or not SLOWEST < velocity < np.inf:
        velocity = VELOCITY
        missing.append("velocity")
    if effort is None or not 0 < effort < np.inf:
        effort = TORQUE
        missing.append("torque")
    return values | {"velocity": velocity, "acceleration": ACCELERATION, "jerk": JERK, "torque": effort}, missing


def _arm(arm: GuessedArm, prefix: str) -> dict[str, Any]:
    return {
        "joints": [prefix + name for name in arm.joints],
        "tcp": prefix + arm.tcp,
        "shoulder": prefix + arm.shoulder,
        "elbow": prefix + arm.elbow,
        "wrist": prefix + arm.wrist,
        "length": 1.0,
        "hand": {
            "body": prefix + arm.hand,
            "approach": list(arm.approach),
            "opening": list(arm.opening),
            "max_width": arm.max_width,
        },
    }


def _turn_to_forward(robot: Robot) -> int:
    """Yaw in degrees, a multiple of 90, that brings the left shoulder to the left of the right one."""
    frames = [robot.arms[side].shoulder_frame for side in ("left", "right")]
    left, right = robot.kinematics(robot.home[None], frames).position[0]
    across = left - right
    if np.hypot(across[0], across[1]) < 1e-3:
        return 0
    heading = np.rad2deg(np.arctan2(-across[0], across[1]))
    return int(-90 * round(heading / 90))


def _measured(content: dict[str, Any], robot: Robot) -> dict[str, Any]:
    """With arm lengths, where the robot stands, and a home posture with the hands before it."""
    generator = np.random.default_rng(0)
    low = np.where(np.isfinite(robot.lower), robot.lower, -np.pi)
    high = np.where(np.isfinite(robot.upper), robot.upper, np.pi)
    q = generator.uniform(low, high, (4000, len(low)))
    shoulders = []
    for side, arm in robot.arms.items():
        tcp, shoulder = robot.kinematics(q, [arm.tcp_frame, arm.shoulder_frame]).position.swapaxes(0, 1)
        content["arms"][side]["length"] = round(float(np.linalg.norm(tcp - shoulder, axis=1).max()), 3)
        shoulders.append(shoulder.mean(axis=0))
    length = content["arms"]["left"]["length"]
    if len(content["parts"]) == 2:
        half = round(ARM_SPACING / 2 * length, 2)
        content["parts"][0]["position"], content["parts"][1]["position"] = [0, half, 0], [0, -half, 0]
        shoulders = [at + np.array([0, sign * half, 0]) for at, sign in zip(shoulders, (1, -1), strict=True)]
    middle = np.mean(shoulders, axis=0)
    ahead = round(WORK_AHEAD - WORK_REACH * length - float(middle[0]), 2)
    up = -round(float(middle[2]) - SHOULDER_HEIGHT, 2) if middle[2] > STANDS_ON_FLOOR else 0
    content["base_in_agent"]["position"] = [0, ahead, up]
    for side, arm in robot.arms.items():
        home = _home(robot, side, low, high, generator)
        for column in arm.joint_indices:
            content["joints"][robot.joint_names[column]]["home"] = round(float(home[column]), 3)
    return content


def _home(robot: Robot, side: ArmName, low: Floats, high: Floats, generator: np.random.Generator) -> Floats:
    """A posture with the hand half an arm's length ahead, pointing forward and down, joints away from their limits."""
    arm = robot.arms[side]
    length = robot.description.arms[side].length
    columns = arm.joint_indices
    margin = 0.03 * (high - low)
    mean, spread = 0.5 * (low + high), 0.3 * (high - low)
    best = mean
    for _ in range(ROUNDS):
        q = np.tile(mean, (SAMPLES, 1))
        q[:, columns] += spread[columns] * generator.standard_normal((SAMPLES, len(columns)))
        q = np.clip(q, low + margin, high - margin)
        kinematics = robot.kinematics(q, [arm.tcp_frame, arm.shoulder_frame])
        tcp, shoulder = kinematics.position.swapaxes(0, 1)
        reach = float(np.linalg.norm(tcp - shoulder, axis=1).max()) if length == 1.0 else length
        wanted = shoulder + reach * np.array([0.5, 0.0, -0.1])
        pointing = kinematics.rotation[:, 0] @ np.array(arm.hand.approach) @ np.array([0.6, 0.0, -0.8])
        centred = np.square((q - 0.5 * (low + high)) / (high - low))[:, columns].mean(axis=1)
        cost = np.linalg.norm(tcp - wanted, axis=1) / reach + 0.3 * (1 - pointing) + 0.5 * centred
        elite = q[np.argsort(cost)[:ELITE]]
        best, mean, spread = elite[0], elite.mean(axis=0), elite.std(axis=0) + 0.02
    return best


def _touching(robot: Robot) -> list[list[str]]:
    """Pairs of one arm's or the body's shapes that overlap at home or nearly always: neighbours in the model."""
    generator = np.random.default_rng(1)
    low = np.where(np.isfinite(robot.lower), robot.lower, -np.pi)
    high = np.where(np.isfinite(robot.upper), robot.upper, np.pi)
    q = np.concatenate([robot.clip(robot.home)[None], generator.uniform(low, high, (100, len(low)))])
    near = CollisionModel(robot, {}).near(q, {}, margin=0.0)
    samples: dict[tuple[str, str], set[int]] = {}
    for sample, first, second in zip(near.sample, near.first, near.second, strict=True):
        samples.setdefault((first, second), set()).add(int(sample))
    return [list(pair) for pair, at in sorted(samples.items()) if 0 in at or len(at) > 0.8 * len(q)]


def _listed(words: Iterable[str], most: int = 4) -> str:
    words = list(words)
    more = f" and {len(words) - most} more" if len(words) > most else ""
    return ", ".join(words[:most]) + more


def _yaml(content: Mapping[str, Any]) -> str:
    """The description as YAML with a comment at every field."""

    def flow(value: Any) -> str:
        if isinstance(value, dict):
            return "{" + ", ".join(f"{key}: {flow(item)}" for key, item in value.items()) + "}"
        if isinstance(value, (list, tuple)):
            return "[" + ", ".join(map(flow, value)) + "]"
        if isinstance(value, float):
            return f"{value:.6g}" if value != int(value) or abs(value) > 1e6 else str(int(value))
        return msgspec.json.encode(value).decode() if isinstance(value, str) else str(value).lower()

    lines = [
        "# Description of a robot, guessed from its model file. Look at everything and mend what is wrong;",
        '# `sbam robots check` loads it, reports and draws it. All fields: docs, "Robots".',
        f"format_version: {content['format_version']}",
        f"name: {flow(content['name'])}",
        f"note: {flow(content['note'])}",
        "",
        "# Model files and where they are mounted in the robot's frame (x forward, y left, z up; m, degrees).",
        "# If the robot does not look along x: rotation_rpy_deg.",
        "parts:",
        *(f"  - {flow(part)}" for part in content["parts"]),
        "# Where the robot's frame stands in the agent frame (x right, y forward, z up; origin on the table top).",
        "# Yaw 90: the robot's x axis is the agent's forward. A negative height: that far below the table top.",
        f"base_in_agent: {flow(content['base_in_agent'])}",
        "",
        "# Planned joints; rad, rad/s, rad/s^2, rad/s^3, Nm (or m and N). home: where the arms start and end.",
        "# lower and upper, where they are given, replace the model's position limits.",
        "joints:",
        *(f"  {flow(name)}: {flow(joint)}" for name, joint in content["joints"].items()),
        "# All other joints, and where they are held (fingers: open).",
        "locked_joints:" if content["locked_joints"] else "locked_joints: {}",
        *(f"  {flow(name)}: {flow(value)}" for name, value in content["locked_joints"].items()),
        "# Planned joints that move both arms. To plan a lift, move it from locked_joints to joints and here.",
        f"torso_joints: {flow(content['torso_joints'])}",
        "",
        "arms:",
    ]
    for side, arm in content["arms"].items():
        hand = arm["hand"]
        lines += [
            f"  {side}:",
            "    # from shoulder to hand",
            f"    joints: {flow(arm['joints'])}",
            "    # body or site whose frame is brought to the grasps",
            f"    tcp: {flow(arm['tcp'])}",
            "    # frames at the centre of the shoulder, at the elbow and at the wrist, for human-likeness",
            f"    shoulder: {flow(arm['shoulder'])}",
            f"    elbow: {flow(arm['elbow'])}",
            f"    wrist: {flow(arm['wrist'])}",
            "    # largest distance of TCP and shoulder, m",
            f"    length: {flow(arm['length'])}",
            "    # approach, opening: unit vectors in the TCP frame; a hand that presses its palm against things",
            "    # has `fingers`, where they point, instead of `opening`. max_width: the widest object, m.",
            "    hand:",
            *(f"      {key}: {flow(value)}" for key, value in hand.items()),
        ]
    lines += [
        "",
        "# Pairs of bodies that are not compared in collision checks: they overlap in most postures of the model.",
        f"may_touch: {flow([])}" if not content["may_touch"] else "may_touch:",
        *(f"  - {flow(pair)}" for pair in content["may_touch"]),
        "# Whether plans prefer a person's natural postures; for arms that are built like a person's.",
        f"human_likeness: {flow(content['human_likeness'])}",
    ]
    return "\n".join(lines) + "\n"
