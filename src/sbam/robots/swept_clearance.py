"""Clearances of a whole motion: every sample counts, few have to be looked at (conservative advancement).

Between two samples no point of a shape goes farther than the joints that move it, times their largest levers, and the
object that it belongs to. A pair of shapes whose distances are d and d' at the ends of an interval, and which move by
L relative to each other within it, keeps (d + d' - L) / 2 throughout. Intervals in which that leaves room for less than
the least distance that is known are halved, down to single samples.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from sbam.robots.collision import ClearanceReport, CollisionModel, ExactDistances, Held
from sbam.robots.collision_pairs import PAIR_CLASSES, hand_bodies

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

STRIDE = 128  # samples between those that are looked at first
SOME = 2  # of those, every so many are looked at before the others, of which less is near enough to matter then
SLACK = 0.005  # m: pairs whose bound is less than this beyond the least distance are measured


def swept_clearances(
    collision: CollisionModel,
    configurations: Floats,
    T_world_object: Mapping[str, RigidTransform],
    held: Held | None = None,
    rigid: Held | None = None,
    distance_max: float = 0.1,
) -> ClearanceReport:
    """Smallest distance of each class of pairs over all samples of one motion.

    Equal to ``collision.clearances(..., motions=1)``, but for distances between a hand and what it holds rigidly: those
    are known up to what the hold slips.

    Args:
        collision: shapes of the robot and the objects.
        configurations: (N, n) joint positions, N > 0.
        T_world_object: every object's pose in the world: one, or N of them.
        held: (object, arm) -> (N,) mask of the samples at which that hand's fingers may touch that object.
        rigid: (object, arm) -> (N,) mask of the samples at which the object moves as one with the hand.
        distance_max: farther pairs are not looked at, m.

    Raises:
        ConfigurationError: if the configurations have another shape or are not finite.
        UnknownNameError: if an object's pose is missing, or a held object or an arm is not known.
    """
    q = collision.robot.checked(configurations)
    search = _Search(collision, q, T_world_object, held or {}, distance_max)
    travel, share = _travel(collision, q, T_world_object)
    tied, together = _rigid_pairs(collision, rigid or {}, len(q))

    def may_be_nearer(intervals: _Intervals) -> NDArray[np.bool_]:
        """Which intervals have samples inside that may be nearer than what is known."""
        i, j, pair = intervals.begin, intervals.end, intervals.pair
        moved = np.vecdot(travel[j] - travel[i], share[pair])
        tie = tied[pair]
        moved[(tie >= 0) & together[tie, i] & together[tie, j]] = 0.0
        least = 0.5 * (intervals.at_begin + intervals.at_end - moved)
        return (j - i > 1) & (least < search.least[intervals.kind])

    samples = _first_samples(len(q), [*(held or {}).values(), *(rigid or {}).values()])
    intervals = search.start(samples, travel, share)
    intervals = intervals.those(may_be_nearer(intervals))
    while len(intervals.begin):
        middle = (intervals.begin + intervals.end) // 2
        distance, kind = search.look(middle, intervals.pair)
        intervals = intervals.halved(middle, distance, kind)
        intervals = intervals.those(may_be_nearer(intervals))
    return search.report()


@dataclass(frozen=True)
class _Intervals:
    """Pairs of shapes over spans of samples, (K,) each: where they begin and end, the distances there, the class."""

    begin: Integers
    end: Integers
    pair: Integers
    kind: Integers
    at_begin: Floats
    at_end: Floats

    def those(self, mask: NDArray[np.bool_]) -> _Intervals:
        return _Intervals(*(getattr(self, name)[mask] for name in self.__dataclass_fields__))

    def halved(self, middle: Integers, distance: Floats, kind: Integers) -> _Intervals:
        return _Intervals(
            np.concatenate([self.begin, middle]),
            np.concatenate([middle, self.end]),
            np.tile(self.pair, 2),
            np.concatenate([self.kind, kind]),
            np.concatenate([self.at_begin, distance]),
            np.concatenate([distance, self.at_end]),
        )


class _Search:
    """Looks at pairs at single samples and remembers the least distance of each class."""

    def __init__(
        self,
        collision: CollisionModel,
        configurations: Floats,
        T_world_object: Mapping[str, RigidTransform],
        held: Held,
        distance_max: float,
    ) -> None:
        kinds = len(PAIR_CLASSES)
        self._collision, self._configurations = collision, configurations
        self._objects, self._held, self._distance_max = T_world_object, held, distance_max
        self.least = np.full(kinds, distance_max)
        self._closest, self._when = np.full(kinds, -1), np.full(kinds, -1)

    def _poses(self, samples: Integers) -> tuple[Floats, Floats]:
        objects = {name: pose if pose.single else pose[samples] for name, pose in self._objects.items()}
        return self._collision.shapes.poses(self._configurations[samples], objects)

    def start(self, samples: Integers, travel: Floats, share: Floats) -> _Intervals:
        """Intervals between the first samples, of all pairs that may come near."""
        pairs = self._collision.pairs
        position = self._poses(samples)[0]
        distance = self._collision.shapes.sphere_distance(position, pairs)
        kind = np.zeros(distance.shape, dtype=np.int64)

        def look(which: NDArray[np.bool_]) -> None:
            row, pair = np.nonzero(which)
            distance[which], kind[which] = self.look(samples[row], pair)

        some = np.arange(len(samples)) % SOME == 0
        look((distance < self._distance_max) & some[:, None])
        moved = np.diff(travel[samples], axis=0) @ share.T
        near = 0.5 * (distance[1:] + distance[:-1] - moved) < self._farthest()
        ends = distance < self._farthest()
        ends[:-1] |= near
        ends[1:] |= near
        look(ends & ~some[:, None])
        row, pair = np.nonzero(near)
        return _Intervals(
            samples[row], samples[row + 1], pair, kind[row, pair], distance[row, pair], distance[row + 1, pair]
        )

    def _farthest(self) -> Floats:
        """(P,) the least distance known of each pair's class; what a hand holds may be of either of two."""
        least = self.least.copy()
        held, palm = PAIR_CLASSES.index("arm-object"), PAIR_CLASSES.index("palm-object")
        least[held] = max(least[held], least[palm])
        return least[self._collision.classes]

    def look(self, sample: Integers, pair: Integers) -> tuple[Floats, Integers]:
        """Lower bounds (N,) of the distances of pairs (N,) at samples (N,), and their classes (N,).

        What does not count is infinitely far.
        """
        collision = self._collision
        at, row = np.unique(sample, return_inverse=True)
        position, rotation = self._poses(at)
        bound = collision.shapes.lower_bound(position, rotation, row, collision.pairs[pair])
        held = {key: np.asarray(mask, dtype=bool)[at] for key, mask in self._held.items()}
        counts, kind = collision.counting(row, pair, held, len(at))
        bound[~counts] = np.inf
        worth = np.flatnonzero(bound < self.least[kind] + SLACK)
        order = worth[np.argsort(bound[worth], kind="stable")]
        with ExactDistances(collision.shapes, position, rotation) as measure:
            for item, at_row, which in zip(order.tolist(), row[order].tolist(), kind[order].tolist(), strict=True):
                farthest = float(self.least[which]) + SLACK
                if bound[item] < farthest:
                    bound[item] = measure(at_row, collision.pairs[pair[item]], farthest)
                    if bound[item] < self.least[which]:
                        self.least[which] = bound[item]
                        self._closest[which], self._when[which] = pair[item], sample[item]
        return bound, kind

    def report(self) -> ClearanceReport:
        """The least distances found."""
        overall = int(self.least.argmin())
        pairs = [self._collision.names(pair) for pair in self._closest.tolist()]
        return ClearanceReport(
            distance=self.least[[overall]],
            pair=(pairs[overall],),
            distance_by_class={name: self.least[[i]] for i, name in enumerate(PAIR_CLASSES)},
            pair_by_class={name: (pairs[i],) for i, name in enumerate(PAIR_CLASSES)},
            sample_by_class={name: self._when[[i]] for i, name in enumerate(PAIR_CLASSES)},
            distance_max=self._distance_max,
        )


def _first_samples(count: int, masks: list[NDArray[np.bool_]]) -> Integers:
    """Even samples, and those before and after a mask switches: between them nothing changes."""
    switches = [np.flatnonzero(np.diff(mask)) for mask in masks]
    return np.unique(np.concatenate([np.arange(0, count, STRIDE), [count - 1], *switches, *(s + 1 for s in switches)]))


def _travel(
    collision: CollisionModel, configurations: Floats, T_world_object: Mapping[str, RigidTransform]
) -> tuple[Floats, Floats]:
    """How far joints and objects have travelled at each sample, (N, n + O), and what each pair makes of it, (P, n + O).

    Joints that move both shapes of a pair move them as one. Of objects the farthest point counts.
    """
    shapes = collision.shapes
    steps = [np.abs(np.diff(configurations, axis=0))]
    fixed = len(shapes.robot_bodies)
    for owner, name in enumerate(shapes.objects, start=fixed):
        pose = shapes.pose_of(name, T_world_object)
        if pose.single:
            steps.append(np.zeros((len(configurations) - 1, 1)))
            continue
        step = np.diff(pose.as_matrix()[:, :3], axis=0)
        turned = np.sqrt(np.square(step[..., :3]).sum(axis=(1, 2))) * shapes.radius_about_origin(owner)
        steps.append((np.linalg.norm(step[..., 3], axis=1) + turned)[:, None])
    travel = np.zeros((len(configurations), configurations.shape[1] + len(shapes.objects)))
    np.cumsum(np.concatenate(steps, axis=1), axis=0, out=travel[1:])
    levers = shapes.levers()
    own = shapes.owner[:, None] == np.arange(fixed, fixed + len(shapes.objects))
    share = np.concatenate([levers, own], axis=1)
    first, second = share[collision.pairs[:, 0]], share[collision.pairs[:, 1]]
    return travel, np.where((first > 0) & (second > 0), 0.0, first + second)


def _rigid_pairs(collision: CollisionModel, rigid: Held, count: int) -> tuple[Integers, NDArray[np.bool_]]:
    """Which hold each pair of shapes belongs to, (P,), -1 for none, and when each hold is rigid, (holds, N)."""
    shapes = collision.shapes
    index = {name: i for i, name in enumerate(shapes.owners)}
    owners = shapes.owner[collision.pairs].reshape(-1, 2)
    tied = np.full(len(owners), -1)
    for number, (name, side) in enumerate(rigid):
        hand = [index[body] for body in hand_bodies(collision.robot, side) if body in index]
        with_it = (owners == index[shapes.known_object(name)]).any(axis=1)
        tied[with_it & np.isin(owners, hand).any(axis=1)] = number
    masks = [np.asarray(mask, dtype=bool) for mask in rigid.values()]
    return tied, np.array([*masks, np.zeros(count, dtype=bool)])
