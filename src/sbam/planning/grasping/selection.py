"""Choose the grasps with which the whole action can be done, in pairs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.spatial.transform import RigidTransform

from sbam.demonstrations.demonstration import Hand
from sbam.errors import UnreachableError
from sbam.planning.grasping.candidates import Grasp, candidate_grasps
from sbam.planning.grasping.follow_outwards import follow_outwards, solve_hand
from sbam.planning.task import MovedObject, RoleHand, Task
from sbam.robots import NaturalDirections, ObjectHand, Robot
from sbam.robots.collision import CollisionModel

RANDOM_NEAR_HOME = 3  # starts home + N(0, 0.5)
RANDOM_STARTS = 4  # starts anywhere within the limits
ENOUGH = 60  # grasps that work; random starts are not spent on the others then
NEAR_LIMIT = 0.05  # rad: postures nearer to a limit rank lower
FOLLOW = 48  # grasps that are followed through the action at once, the most promising first
EXAMINE = 48  # best grasps of each hand whose clearance is measured
KEEP = 24  # best grasps of each hand that are combined
COMBINATIONS = 60  # combinations whose clearance is measured at once, the best first
MOST = 4  # times that
ENOUGH_CLEAR = 6  # combinations that keep clear; more are not looked for
HUMAN = 0.7  # score per unit of the weighted t_h, and of other terms about the posture
AMPLE = 0.03  # m: more clearance than this is not better


@dataclass(frozen=True, eq=False)  # each is itself: searches remember those that they tried
class FollowedGrasp:
    """A grasp with which one arm can follow its object through all checkpoints.

    Attributes:
        grasp: the grasp.
        configurations: at the checkpoints; only the arm's joints count.
        score: lower is better.
    """

    grasp: Grasp
    configurations: Float[np.ndarray, "checkpoints joints"]
    score: float


def follow_grasps(
    robot: Robot,
    collision: CollisionModel,
    moved: MovedObject,
    hand: Hand,
    poses: RigidTransform,
    seed: int = 0,
    human_likeness: float = 0.0,
) -> list[FollowedGrasp]:
    """All candidate grasps of one hand that work at every checkpoint, best first.

    Inverse kinematics is started from eight postures at the hardest checkpoint, the one of largest tilt, and goes
    outwards both ways from what is found there.

    Args:
        robot: robot standing in the agent frame.
        collision: shapes of the robot and the scene's objects.
        moved: the object.
        hand: the hand.
        poses: poses of the object at the checkpoints, agent frame, in order of time.
        seed: of the random starts.
        human_likeness: weight of the posture's distance from a person's.

    Raises:
        UnreachableError: if none works; says which checkpoint and how near the best came.
    """
    grasps = candidate_grasps(robot, collision, moved, hand)
    joints = np.flatnonzero(robot.frame_joints(robot.arms[hand].tcp_frame))
    checkpoints, count = len(poses), len(grasps)
    T_object_tcp = np.array([grasp.T_object_tcp.as_matrix() for grasp in grasps])
    T_agent_tcp = poses.as_matrix() @ T_object_tcp[:, None]  # (G, M, 4, 4)
    position, rotation = T_agent_tcp[..., :3, 3], T_agent_tcp[..., :3, :3]
    hardest = int(np.argmax((poses.rotation * moved.start.rotation.inv()).magnitude()))

    q, reached, nearest = _at_hardest(robot, hand, position[:, hardest], rotation[:, hardest], seed)
    posture = _Posture(robot, hand, human_likeness)
    cost = _limit_cost(robot, q, joints) + 0.1 * np.abs(q - robot.home)[..., joints].max(-1) + posture.cost(q)
    rank = np.where(reached, cost, np.inf)
    first = q[np.arange(count), rank.argmin(axis=1)]
    reachable = np.flatnonzero(reached.any(axis=1))
    promise = rank.min(axis=1)[reachable] + 0.5 * np.array([grasps[g].human_distance for g in reachable])
    path = np.empty((count, checkpoints, q.shape[-1]))
    failed_at = np.full(count, hardest)
    works = np.zeros(count, dtype=bool)
    for batch in np.array_split(reachable[np.argsort(promise)], range(FOLLOW, len(reachable), FOLLOW)):
        followed = follow_outwards(robot, hand, position[batch], rotation[batch], first[batch], hardest)
        path[batch], failed_at[batch] = followed.configurations, followed.broken_at
        works[batch] = failed_at[batch] < 0
        if works.sum() >= KEEP:
            break
    if not works.any():
        hard = int(np.bincount(failed_at, minlength=checkpoints).argmax())
        where = "where it is tilted most" if hard == hardest else f"{hard / (checkpoints - 1):.0%} on its way"
        missed = f" (the nearest misses by {1e3 * nearest:.0f} mm)" if not reached.any() else ""
        raise UnreachableError(
            f"{robot.name}'s {hand} hand can hold {moved.name!r} with none of {count} grasps through the whole action; "
            f"most fail {where}{missed}; `sbam reach` says where the robot or the objects would have to be"
        )
    return sorted(
        (
            FollowedGrasp(
                grasps[g], path[g], _score(robot, grasps[g], path[g], joints) + float(posture.cost(path[g]).mean())
            )
            for g in np.flatnonzero(works)
        ),
        key=lambda followed: followed.score,
    )


class _Posture:
    """What an arm's distance from a person's posture adds to a score."""

    def __init__(self, robot: Robot, hand: Hand, weight: float) -> None:
        self._robot, self._weight = robot, weight
        self._arm = list(robot.arms).index(hand)
        self._human = NaturalDirections(robot) if weight > 0.0 else None

    def cost(self, configurations: Float[np.ndarray, "*batch joints"]) -> Float[np.ndarray, "*batch"]:
        """Score of each configuration."""
        shape = configurations.shape[:-1]
        if self._human is None:
            return np.zeros(shape)
        flat = configurations.reshape(-1, configurations.shape[-1])
        residual = self._human.residual(self._robot.kinematics(flat, self._human.frames))
        own = residual.reshape(len(flat), len(self._robot.arms), -1)[:, self._arm]
        return HUMAN * self._weight * 0.5 * np.square(own).sum(axis=1).reshape(shape)


def _at_hardest(
    robot: Robot,
    hand: Hand,
    position: Float[np.ndarray, "grasps 3"],
    rotation: Float[np.ndarray, "grasps 3 3"],
    seed: int,
) -> tuple[Float[np.ndarray, "grasps starts joints"], Bool[np.ndarray, "grasps starts"], float]:
    """Solve poses of one hand from all starts; the random ones only where the others do not reach.

    Returns:
        Configurations, which of them reach, and the smallest position error, m.
    """
    starts = _starts(robot, hand, seed)
    count, known = len(position), len(starts) - RANDOM_NEAR_HOME - RANDOM_STARTS
    q = np.tile(starts, (count, 1, 1))
    reached = np.zeros((count, len(starts)), dtype=bool)
    nearest = np.inf
    for tried in (slice(0, known), slice(known, len(starts))):
        left = np.flatnonzero(~reached.any(axis=1))
        if len(left) == 0 or count - len(left) >= ENOUGH:
            break
        begin = starts[tried]
        solution = solve_hand(
            robot,
            hand,
            np.repeat(position[left], len(begin), axis=0),
            np.repeat(rotation[left], len(begin), axis=0),
            np.tile(begin, (len(left), 1)),
        )
        near = robot.turned_near(solution.configurations, robot.home)  # no turn more than needed
        q[left, tried] = near.reshape(len(left), len(begin), -1)
        reached[left, tried] = solution.reached().reshape(len(left), len(begin))
        nearest = min(nearest, float(solution.position_error.min()))
    return q, reached, nearest


def _starts(robot: Robot, hand: Hand, seed: int) -> Float[np.ndarray, "starts joints"]:
    """Eight postures and the description's seeds."""
    generator = np.random.default_rng(seed)
    home = robot.clip(robot.home)
    lower = np.where(np.isfinite(robot.lower), robot.lower, -np.pi)
    upper = np.where(np.isfinite(robot.upper), robot.upper, np.pi)
    near = robot.clip(home + 0.5 * generator.standard_normal((RANDOM_NEAR_HOME, len(home))))
    anywhere = generator.uniform(lower, upper, (RANDOM_STARTS, len(home)))
    arm = robot.arms[hand]
    seeds = np.tile(home, (len(arm.ik_seeds), 1))
    seeds[:, arm.joint_indices] = arm.ik_seeds
    return np.concatenate([home[None], seeds, near, anywhere])


def _limit_cost(
    robot: Robot, q: Float[np.ndarray, "*batch joints"], joints: Int[np.ndarray, " arm_joints"]
) -> Float[np.ndarray, "*batch"]:
    """How much postures press against the joint limits."""
    room = np.minimum(q - robot.lower, robot.upper - q)[..., joints].min(axis=-1)
    return np.maximum(0.0, 1.0 - room / NEAR_LIMIT)


def _score(
    robot: Robot, grasp: Grasp, path: Float[np.ndarray, "checkpoints joints"], joints: Int[np.ndarray, " arm_joints"]
) -> float:
    jump = float(np.abs(np.diff(path, axis=0))[:, joints].max(initial=0.0))
    travel = float(np.abs(np.diff(path, axis=0))[:, joints].sum(axis=1).mean()) if len(path) > 1 else 0.0
    limits = float(_limit_cost(robot, path, joints).max())
    return jump + 0.5 * travel + limits + 0.5 * grasp.human_distance


def choose_grasps(
    task: Task,
    robot: Robot,
    collision: CollisionModel,
    poses: Mapping[str, RigidTransform],
    times: Float[np.ndarray, " checkpoints"],
    seed: int = 0,
    human_likeness: float = 0.0,
    posture: Callable[[Mapping[tuple[str, Hand], RigidTransform], Float[np.ndarray, "checkpoints joints"]], float]
    | None = None,
) -> list[dict[RoleHand, FollowedGrasp]]:
    """Combinations of grasps for all hands, best first.

    Each grasp works by itself at all checkpoints from its object's lift to its place; the combinations are ranked by
    the clearance that arms, hands and objects keep from each other there. An arm that holds nothing is at home.

    Args:
        task: model bound to a scene.
        robot: robot standing in the agent frame.
        collision: shapes of the robot and the scene's objects.
        poses: role -> poses at the checkpoints, agent frame.
        times: of the checkpoints, model's time axis, s.
        seed: of the random starts.
        human_likeness: lambda_h, by which grasps are preferred that let the arm take a person's posture.
        posture: what else counts of the posture, from the grasps of all hands and the configurations. It ranks the
            combinations, which are made of the grasps that are best for each hand without it.

    Returns:
        (role, hand) -> grasp, the best `COMBINATIONS` of them.

    Raises:
        UnreachableError: if a hand finds no grasp.
    """
    held = {moved.role: _held(moved, times) for moved in task.moved}
    options = []
    for moved, key in task.holds:
        hand = key.hand
        during = held[moved.role]
        on_way = poses[moved.role][during]
        followed = follow_grasps(robot, collision, moved, hand, on_way, seed, human_likeness)[:EXAMINE]
        followed = [replace(item, configurations=_spread(item.configurations, during)) for item in followed]
        configurations = np.array([_merged(robot, [(moved, hand)], [item], held) for item in followed])
        clearance = _clearances(
            task, collision, configurations, poses, held, ("self", "arm-support", "arm-object", "palm-object")
        )
        scored = [replace(item, score=item.score + _penalty(c)) for item, c in zip(followed, clearance, strict=True)]
        options.append(sorted(scored, key=lambda item: item.score)[:KEEP])
    combinations = sorted(product(*options), key=lambda items: sum(item.score for item in items))
    keys = [key for _, key in task.holds]

    def further(items: Sequence[FollowedGrasp], configurations: Float[np.ndarray, "checkpoints joints"]) -> float:
        """What counts of the posture beside human-likeness, as a score."""
        if posture is None:
            return 0.0
        T_object_tcp: dict[tuple[str, Hand], RigidTransform] = {
            key: item.grasp.T_object_tcp for key, item in zip(keys, items, strict=True)
        }
        return HUMAN * posture(T_object_tcp, configurations)

    if len(options) == 1:
        some = combinations[:COMBINATIONS]
        moved, key = task.holds[0]
        configurations = [_merged(robot, [(moved, key.hand)], items, held) for items in some]
        scores = [items[0].score + further(items, q) for items, q in zip(some, configurations, strict=True)]
        combinations = [some[i] for i in np.argsort(scores, kind="stable")]
    else:
        combinations = _by_arms_clearance(task, robot, collision, combinations, poses, held, further)
    return [dict(zip(keys, items, strict=True)) for items in combinations]


def _by_arms_clearance(
    task: Task,
    robot: Robot,
    collision: CollisionModel,
    combinations: Sequence[tuple[FollowedGrasp, ...]],
    poses: Mapping[str, RigidTransform],
    held: Mapping[str, Bool[np.ndarray, " checkpoints"]],
    further: Callable[[Sequence[FollowedGrasp], Float[np.ndarray, "checkpoints joints"]], float],
) -> list[tuple[FollowedGrasp, ...]]:
    """The combinations ranked with the clearance between the arms; goes on until enough of them keep clear."""
    keys: list[tuple[MovedObject, Hand]] = [(moved, key.hand) for moved, key in task.holds]
    scores: list[float] = []
    clear = 0
    while clear < ENOUGH_CLEAR and len(scores) < min(len(combinations), MOST * COMBINATIONS):
        some = combinations[len(scores) : len(scores) + COMBINATIONS]
        configurations = np.array([_merged(robot, keys, items, held) for items in some])
        clearance = _clearances(task, collision, configurations, poses, held, ("arm-arm",))
        scores += [
            sum(item.score for item in items) + _penalty(c) + further(items, q)
            for items, c, q in zip(some, clearance, configurations, strict=True)
        ]
        clear += int((clearance >= 0.0).sum())
    return [combinations[i] for i in np.argsort(scores)[:COMBINATIONS]]


def _held(moved: MovedObject, times: Float[np.ndarray, " checkpoints"]) -> Bool[np.ndarray, " checkpoints"]:
    """At which checkpoints an object is held: from the last one before its lift to the first after its place."""
    first = max(int(np.searchsorted(times, moved.lift, side="right")) - 1, 0)
    last = min(int(np.searchsorted(times, moved.place)), len(times) - 1)
    index = np.arange(len(times))
    return (index >= first) & (index <= last)


def _spread(
    configurations: Float[np.ndarray, "held joints"], during: Bool[np.ndarray, " checkpoints"]
) -> Float[np.ndarray, "checkpoints joints"]:
    """At all checkpoints what is known at some that follow each other: held on before and after them."""
    return configurations[np.clip(np.cumsum(during) - 1, 0, len(configurations) - 1)]


def _merged(
    robot: Robot,
    keys: Sequence[tuple[MovedObject, Hand]],
    items: Sequence[FollowedGrasp],
    held: Mapping[str, Bool[np.ndarray, " checkpoints"]],
) -> Float[np.ndarray, "checkpoints joints"]:
    """Configurations of all hands together; of those that hold nothing at home."""
    configurations = np.tile(robot.home, (len(items[0].configurations), 1))
    for (moved, hand), item in zip(keys, items, strict=True):
        joints = robot.frame_joints(robot.arms[hand].tcp_frame)
        configurations = np.where(held[moved.role][:, None] & joints, item.configurations, configurations)
    return configurations


def _clearances(
    task: Task,
    collision: CollisionModel,
    configurations: Float[np.ndarray, "grasps checkpoints joints"],
    poses: Mapping[str, RigidTransform],
    held: Mapping[str, Bool[np.ndarray, " checkpoints"]],
    kinds: Sequence[str],
) -> Float[np.ndarray, " grasps"]:
    """Smallest distance of the given classes over all checkpoints of each grasp's configurations, m."""
    grasps, checkpoints, joints = configurations.shape
    every = np.tile(np.arange(checkpoints), grasps)
    objects = dict(task.T_agent_object)
    objects.update({moved.name: poses[moved.role][every] for moved in task.moved})
    by_hand = {ObjectHand(moved.name, hand): held[moved.role][every] for moved in task.moved for hand in moved.hands}
    report = collision.clearances(
        configurations.reshape(-1, joints), objects, by_hand, AMPLE, motions=grasps, classes=kinds
    )
    return np.min([report.distance_by_class[kind] for kind in kinds], axis=0)


def _penalty(clearance: float) -> float:
    """What a small clearance adds to the score: little while there is some, much where things touch."""
    return max(0.0, 1.0 - clearance / AMPLE) + (10.0 + 100.0 * -clearance if clearance < 0 else 0.0)
