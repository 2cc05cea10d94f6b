"""Guess what a robot's model file does not say: which joints are the arms, where the hands are, how it stands."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sbam.errors import FileFormatError
from sbam.robots.composition import stand_on_base
from sbam.robots.description import ArmName
from sbam.robots.model_files import read_model

if TYPE_CHECKING:
    import mujoco

Floats = NDArray[np.float64]

MIRRORED = (
    ("left", "right"),
    ("Left", "Right"),
    ("LEFT", "RIGHT"),
    (r"(?<![A-Za-z])l(?![a-z])", "r"),
    (r"(?<![A-Z])L(?![a-z])", "R"),
    (r"(?<![A-Za-z])l(?=(arm|hand|shoulder|elbow|wrist|gripper))", "r"),
)
TCP_WORDS = ("tcp", "grasp", "tool", "endpoint", "ee_link", "gripper", "hand", "flange")
FEWEST_JOINTS = 4  # of an arm
WIDEST = 0.08  # m: what a hand takes where the fingers do not tell


@dataclass(frozen=True)
class GuessedArm:
    """One arm of a model.

    Attributes:
        joints: from shoulder to hand.
        rest: a position of each within its limits, 0 where that is one.
        tcp: tool centre point: body or site.
        shoulder: body of the second joint, around which arms usually turn.
        elbow: body of the joint nearest to half the way from shoulder to hand.
        wrist: body of the last joint but one.
        hand: body that carries the fingers.
        approach: axis of the TCP frame along which the hand reaches.
        opening: axis of the TCP frame along which the fingers open.
        max_width: m.
        fingers: joints beyond the hand, and where they are open.
    """

    joints: tuple[str, ...]
    rest: tuple[float, ...]
    tcp: str
    shoulder: str
    elbow: str
    wrist: str
    hand: str
    approach: tuple[float, float, float]
    opening: tuple[float, float, float]
    max_width: float
    fingers: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class GuessedArms:
    """The arms of a model file, and its other joints.

    Attributes:
        arms: left and right; a file with a single arm has it under both names.
        is_single: whether the file holds one arm that has to be mounted twice.
        others: joints that belong to no arm, with a position within their limits.
        above: those of them that move both arms.
    """

    arms: dict[ArmName, GuessedArm]
    is_single: bool
    others: dict[str, float]
    above: tuple[str, ...]


def guess_arms(path: Path) -> GuessedArms:
    """Find the arms in a model file by names that differ in left and right, or the one arm that it holds.

    Raises:
        FileFormatError: if the file cannot be used, or holds no chain of joints that could be an arm.
    """
    spec = read_model(path).spec
    stand_on_base(spec)
    try:
        model = spec.compile()
    except ValueError as error:
        raise FileFormatError(path, "", f"MuJoCo cannot compile the model: {error}") from error
    tree = _Tree(model)
    names = set(tree.joint_body)
    twins = {name: _mirrored(name) for name in names}
    pairs = {name: twin for name, twin in twins.items() if twin is not None and twin != name and twin in names}
    chains = _chains(tree, set(pairs))
    if chains:
        left = max(chains, key=lambda chain: (_is_arm(chain), tree.height(chain[0]), len(chain)))
        arms: dict[ArmName, GuessedArm] = {
            "left": _arm(tree, left),
            "right": _arm(tree, [pairs[name] for name in left]),
        }
    else:
        chains = _chains(tree, names)
        if not chains:
            known = ", ".join(sorted(names)) or "none"
            problem = f"no chain of {FEWEST_JOINTS} joints that could be an arm; joints: {known}"
            raise FileFormatError(path, "", problem, "one arm, or two whose names differ in left and right")
        arm = _arm(tree, max(chains, key=len))
        arms = {"left": arm, "right": arm}
    used = {name for arm in arms.values() for name in arm.joints}
    fingers = {name: at for arm in arms.values() for name, at in arm.fingers.items()}
    others = {name: fingers.get(name, tree.rest(name)) for name in tree.joint_body if name not in used}
    first = tree.joint_body[arms["left"].joints[0]]
    above = tuple(name for name in others if tree.joint_body[name] in tree.ancestors(first)[1:])
    return GuessedArms(arms, not set(arms["left"].joints) <= set(pairs), others, above)


def _mirrored(name: str) -> str | None:
    """The name of the same thing on the right, if the name says left."""
    for left, right in MIRRORED:
        if re.search(left, name):
            return re.sub(left, right, name)
    return None


def _is_arm(chain: Iterable[str]) -> bool:
    return any(word in name.lower() for name in chain for word in ("arm", "shoulder", "elbow", "wrist"))


class _Tree:
    """A compiled model as a tree of bodies."""

    def __init__(self, model: mujoco.MjModel) -> None:
        import mujoco

        self.model, self.data = model, mujoco.MjData(model)
        mujoco.mj_kinematics(model, self.data)
        self.joint_body = {model.joint(j).name: int(model.jnt_bodyid[j]) for j in range(model.njnt)}
        self.children: dict[int, list[int]] = {body: [] for body in range(model.nbody)}
        for body in range(1, model.nbody):
            self.children[int(model.body_parentid[body])].append(body)

    def ancestors(self, body: int) -> list[int]:
        """The body itself and all above it, without the world."""
        result = []
        while body:
            result.append(body)
            body = int(self.model.body_parentid[body])
        return result

    def below(self, body: int, through_joints: bool = True) -> list[int]:
        """All bodies below, nearest first."""
        result, queue = [], [body]
        while queue:
            for child in self.children[queue.pop(0)]:
                if through_joints or not self.model.body_jntnum[child]:
                    result.append(child)
                    queue.append(child)
        return result

    def height(self, joint: str) -> float:
        return float(self.data.xanchor[self.model.joint(joint).id, 2])

    def rest(self, joint: str) -> float:
        """Zero, or what is nearest to it within the limits."""
        index = self.model.joint(joint).id
        if not self.model.jnt_limited[index]:
            return 0.0
        return float(np.clip(0.0, *self.model.jnt_range[index]))

    def opened(self, joints: list[str], hand: int) -> dict[str, float]:
        """Where fingers are open: slides at the end of their range, hinges where their links are farthest apart."""
        import mujoco

        model, data = self.model, mujoco.MjData(self.model)
        ids = [model.joint(name).id for name in joints]
        rest = {name: self.rest(name) for name in joints}
        ends = dict(rest)
        for name, index in zip(joints, ids, strict=True):
            if model.jnt_limited[index]:
                ends[name] = float(max(model.jnt_range[index], key=abs))
        slides = {name for name, i in zip(joints, ids, strict=True) if model.jnt_type[i] == mujoco.mjtJoint.mjJNT_SLIDE}
        bodies, spread = self.below(hand), {}
        for choice, values in (("rest", rest), ("end", ends)):
            for name in joints:
                data.joint(name).qpos[:] = values[name]
            mujoco.mj_kinematics(model, data)
            at = data.xpos[bodies]
            spread[choice] = np.linalg.norm(at[:, None] - at[None], axis=-1).max(initial=0.0)
        hinges = ends if spread["end"] > 1.05 * spread["rest"] else rest
        return {name: ends[name] if name in slides else hinges[name] for name in joints}


def _chains(tree: _Tree, names: set[str]) -> list[list[str]]:
    """Unbranched chains of the given joints, each from its uppermost joint down to the hand."""
    owner = {body: name for name, body in tree.joint_body.items() if name in names}
    chains = []
    for body in owner:
        if any(above in owner for above in tree.ancestors(body)[1:]):
            continue
        chain, at = [owner[body]], body
        while True:
            following = [b for b in tree.below(at) if b in owner]
            tops = [b for b in following if not any(a in following for a in tree.ancestors(b)[1:])]
            if len(tops) != 1:
                break
            at = tops[0]
            chain.append(owner[at])
        if len(chain) >= FEWEST_JOINTS:
            chains.append(chain)
    return chains


def _arm(tree: _Tree, joints: list[str]) -> GuessedArm:
    import mujoco

    model, data = tree.model, tree.data
    bodies = [tree.joint_body[name] for name in joints]
    last = bodies[-1]
    finger_bodies = [body for body in tree.below(last) if model.body_jntnum[body]]
    first_fingers = [b for b in finger_bodies if not any(a in finger_bodies for a in tree.ancestors(b)[1:])]
    hand = int(model.body_parentid[first_fingers[0]]) if first_fingers else last
    fixed = [last, *tree.below(last, through_joints=False)]
    frames = [(model.body(b).name, data.xpos[b], data.xmat[b]) for b in fixed]
    frames += [
        (model.site(s).name, data.site_xpos[s], data.site_xmat[s])
        for s in range(model.nsite)
        if int(model.site_bodyid[s]) in fixed
    ]
    wrist_at = data.xanchor[model.joint(joints[-2]).id]
    far = [float(np.linalg.norm(position - wrist_at)) for _, position, _ in frames]
    ranks = [next((i for i, word in enumerate(TCP_WORDS) if word in name.lower()), 99) for name, _, _ in frames]
    best = min(range(len(frames)), key=lambda i: (ranks[i], -far[i]))
    tcp, at, turn = frames[best][0], frames[best][1], frames[best][2].reshape(3, 3)
    reach = at - data.xpos[hand] if np.linalg.norm(at - data.xpos[hand]) > 0.02 else at - wrist_at
    approach = _axis(turn.T @ reach)
    finger_joints = [name for name, body in tree.joint_body.items() if body in finger_bodies]
    opened = tree.opened(finger_joints, hand)
    slides = [n for n in finger_joints if model.jnt_type[model.joint(n).id] == mujoco.mjtJoint.mjJNT_SLIDE]
    opening, width = _axis(np.array([0.0, 1.0, 0.5]) * (1 - np.abs(approach))), WIDEST
    if slides:
        along = turn.T @ data.xaxis[model.joint(slides[0]).id]
        across = np.abs(along) * (1 - np.abs(approach))
        opening = _axis(across) if across.max() > 0.5 else opening
        travel = sum(abs(opened[name]) for name in slides[:2])
        width = round(travel, 3) if 0.02 < travel < 0.3 else WIDEST
    anchors = data.xanchor[[model.joint(name).id for name in joints]]
    return GuessedArm(
        joints=tuple(joints),
        rest=tuple(tree.rest(name) for name in joints),
        tcp=tcp,
        shoulder=model.body(bodies[1]).name,
        elbow=model.body(bodies[_middle(anchors)]).name,
        wrist=model.body(bodies[-2]).name,
        hand=model.body(hand).name,
        approach=approach,
        opening=opening,
        max_width=width,
        fingers=opened,
    )


def _middle(anchors: Floats) -> int:
    """The joint nearest to half the way from the second to the last but one, apart from both where there is one."""
    steps = np.linalg.norm(np.diff(anchors, axis=0), axis=1)
    way = np.concatenate([[0.0], np.cumsum(steps)])
    inner = range(2, len(anchors) - 2) if len(anchors) > 4 else range(1, len(anchors) - 1)
    return min(inner, key=lambda i: abs(way[i] - 0.5 * (way[1] + way[-2])))


def _axis(direction: Floats) -> tuple[float, float, float]:
    """The coordinate axis nearest to a direction."""
    largest = int(np.argmax(np.abs(direction)))
    values = [0.0, 0.0, 0.0]
    values[largest] = float(np.copysign(1.0, direction[largest]))
    return values[0], values[1], values[2]
