"""How well a robot reaches what a task asks of its hands, for many places of its base at once.

Only kinematics count here: joint limits, but neither collisions nor speeds. To stand elsewhere is the same as having
the targets elsewhere, so one batch of inverse kinematics serves all bases.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import RigidTransform

from sbam.demonstrations.demonstration import Hand
from sbam.planning.grasping.candidates import candidate_grasps
from sbam.planning.grasping.follow_outwards import distance_missed, follow_outwards, solve_hand
from sbam.planning.motion.transfer import STANDOFFS
from sbam.planning.task import Task
from sbam.robots import Robot
from sbam.robots.collision import CollisionModel

GRASPS = 24  # of the candidates, drawn at random, where many bases are measured
CHECKPOINTS = 5  # evenly from the first lift to the last place, fewer than where grasps are chosen: likewise
REACHED = 2e-3  # m: a smaller miss is none
WORTH_ANOTHER_START = 0.3  # m: what misses by more than this from one start is out of reach
NOT_FOLLOWED = 1  # grasps that are followed through the action where none reaches the hardest checkpoint
ITERATIONS = 20  # of inverse kinematics, fewer than where grasps are chosen: hundreds of bases are measured


@dataclass(frozen=True)
class HandTargets:
    """Where one hand has to be for each of its grasps at moments, in order of time, agent frame.

    The first and the last are the standoffs before the grasp and after the release.

    Attributes:
        role: role of the object.
        hand: the hand that holds it.
        position: of the tool centre point, m.
        rotation: its orientation.
        hardest: the moment of the largest tilt, from which grasps are followed both ways.
    """

    role: str
    hand: Hand
    position: Float[np.ndarray, "grasps moments 3"]
    rotation: Float[np.ndarray, "grasps moments 3 3"]
    hardest: int


@dataclass(frozen=True)
class Reach:
    """How well places of the base do, for each hand in the order of the targets.

    Attributes:
        miss: how far the hand stays away at its worst moment with its best grasp, m; a radian of orientation
            counts 0.25 m; 0 where it reaches.
        share: share of the grasps that reach every moment.
    """

    miss: Float[np.ndarray, "bases hands"]
    share: Float[np.ndarray, "bases hands"]


def hand_targets(
    task: Task, robot: Robot, poses: Mapping[str, RigidTransform], seed: int = 0, most: int = GRASPS
) -> tuple[HandTargets, ...]:
    """What a task asks of a robot's hands.

    Args:
        task: model bound to a scene.
        robot: its hands say which grasps there are; where it stands is of no account.
        poses: role -> poses at the model's keypoints, agent frame.
        seed: of the choice among the grasps.
        most: how many grasps of each hand are chosen.

    Raises:
        UnreachableError: if no grasp fits a hand.
    """
    generator = np.random.default_rng(seed)
    collision = CollisionModel(robot, task.scene.objects)
    times = task.model.keypoint_times
    targets = []
    for moved in task.moved:
        inside = np.flatnonzero((times >= moved.lift - 1e-9) & (times <= moved.place + 1e-9))
        chosen = np.unique(np.linspace(inside[0], inside[-1], CHECKPOINTS).round().astype(int))
        tilt = (poses[moved.role].rotation * moved.start.rotation.inv()).magnitude()
        most_tilted = int(inside[np.argmax(tilt[inside])])
        moments = np.unique(np.append(chosen, most_tilted))
        along = RigidTransform.concatenate([moved.start, poses[moved.role][moments], moved.put_down])
        for hand in moved.hands:
            grasps = candidate_grasps(robot, collision, moved, hand)
            some = generator.permutation(len(grasps))[:most]
            approach = np.array(robot.arms[hand].hand.approach)
            positions, rotations = [], []
            for grasp in (grasps[i] for i in some):
                tcp = along * grasp.T_object_tcp
                away = np.zeros((len(tcp), 1))
                away[[0, -1]] = min(STANDOFFS)
                positions.append(tcp.translation - away * tcp.rotation.apply(approach))
                rotations.append(tcp.rotation.as_matrix())
            hardest = 1 + int(np.searchsorted(moments, most_tilted))
            targets.append(HandTargets(moved.role, hand, np.array(positions), np.array(rotations), hardest))
    return tuple(targets)


def reach_from(
    robot: Robot, targets: tuple[HandTargets, ...], T_agent_base: RigidTransform, random_starts: int = 0
) -> Reach:
    """Measure how well a robot reaches from places of its base.

    Args:
        robot: the robot; where it stands is of no account.
        targets: what its hands have to do.
        T_agent_base: poses of its frame (x forward, y left, z up) in the agent frame.
        random_starts: postures around home from which inverse kinematics is started, beside home and the seeds of the
            robot's description.
    """
    at_origin = robot.placed(RigidTransform.identity())
    measured = [_hand_reach(at_origin, target, T_agent_base.inv(), random_starts) for target in targets]
    return Reach(np.stack([miss for miss, _ in measured], axis=1), np.stack([share for _, share in measured], axis=1))


def _hand_reach(
    robot: Robot, target: HandTargets, T_base_agent: RigidTransform, random_starts: int
) -> tuple[Float[np.ndarray, " bases"], Float[np.ndarray, " bases"]]:
    """Miss and share of the grasps that reach."""
    turn = T_base_agent.rotation.as_matrix()
    bases, (grasps, moments) = len(turn), target.position.shape[:2]
    position = np.einsum("bij,gmj->bgmi", turn, target.position) + T_base_agent.translation[:, None, None]
    rotation = np.einsum("bij,gmjk->bgmik", turn, target.rotation)
    position = position.reshape(bases * grasps, moments, 3)
    rotation = rotation.reshape(bases * grasps, moments, 3, 3)
    hand, hardest = target.hand, target.hardest

    arm = robot.arms[hand]
    home = robot.clip(robot.home)
    q, miss = np.tile(home, (len(position), 1)), np.full(len(position), np.inf)
    near = home + 0.5 * np.random.default_rng(0).standard_normal((random_starts, len(home)))
    for seed in (home[arm.joint_indices], *arm.ik_seeds, *robot.clip(near)[:, arm.joint_indices]):
        left = np.flatnonzero((miss > REACHED) & ((miss < WORTH_ANOTHER_START) | ~np.isfinite(miss)))
        start = home.copy()
        start[arm.joint_indices] = seed
        again = np.tile(start, (len(left), 1))
        found = solve_hand(robot, hand, position[left, hardest], rotation[left, hardest], again, ITERATIONS)
        off = distance_missed(found)
        better = off < miss[left]
        q[left[better]], miss[left[better]] = found.configurations[better], off[better]
    # Where no grasp reaches, the nearest one is followed all the same: how much is missing depends on it.
    table = miss.reshape(bases, grasps)
    nearest = np.argsort(table, axis=1)[:, :NOT_FOLLOWED] + grasps * np.arange(bases)[:, None]
    followed = miss <= REACHED
    followed[nearest[~(table <= REACHED).any(axis=1)].ravel()] = True
    paths = follow_outwards(
        robot, hand, position[followed], rotation[followed], q[followed], hardest, give_up=False, iterations=ITERATIONS
    )
    miss[~followed] = np.inf
    miss[followed] = np.maximum(miss[followed], paths.miss.max(axis=1, initial=0.0))
    table = miss.reshape(bases, grasps)
    least = table.min(axis=1)
    return np.where(least <= REACHED, 0.0, least), (table <= REACHED).mean(axis=1)
