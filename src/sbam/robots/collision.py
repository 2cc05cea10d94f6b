"""Collision checks: clearances between arms, body, furniture and objects over many configurations."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import RigidTransform

from sbam.errors import UnknownNameError
from sbam.robots.collision_pairs import PAIR_CLASSES, collision_pairs, gripping_bodies, hand_bodies
from sbam.robots.collision_shapes import CollisionShapes
from sbam.robots.description import ArmName
from sbam.robots.robot import Robot
from sbam.scene import ObjectModel

Floats = NDArray[np.float64]


class ObjectHand(NamedTuple):
    """A hand, and the object of the scene that it holds or may touch."""

    object: str
    hand: ArmName


Held = Mapping[ObjectHand, NDArray[np.bool_]]
"""(object, hand) -> (N,) in which samples that hand may touch that object."""


@dataclass(frozen=True)
class NearPairs:
    """N pairs of shapes that are near each other; what a planner needs to push them apart.

    ``d distance / dt = normal . (velocity of point_first - velocity of point_second)``.

    Attributes:
        sample: (N,) index of the configuration.
        pair_class: (N,) index into `PAIR_CLASSES`.
        first: N names of a robot's body or of an object.
        second: N names of a robot's body or of an object.
        distance: (N,) m; negative: depth of penetration.
        point_first: (N, 3) nearest point of the first shape, world, m.
        point_second: (N, 3) nearest point of the second shape, world, m.
        normal: (N, 3) unit vector that points from the second to the first; zero where they just touch.
    """

    sample: NDArray[np.int64]
    pair_class: NDArray[np.int64]
    first: tuple[str, ...]
    second: tuple[str, ...]
    distance: Floats
    point_first: Floats
    point_second: Floats
    normal: Floats


@dataclass(frozen=True)
class ClearanceReport:
    """Smallest distances of M motions, or of as many single samples.

    Attributes:
        distance: (M,) smallest over all pairs, m; negative in penetration, at most ``distance_max``.
        pair: M pairs of names (robot bodies or objects) that are nearest, or None where nothing is within it.
        distance_by_class: the same for each of `PAIR_CLASSES`.
        pair_by_class: the same for each of `PAIR_CLASSES`.
        sample_by_class: (M,) index of the sample at which they are nearest, for each of `PAIR_CLASSES`; -1 where
            nothing is within ``distance_max``.
        distance_max: m; farther pairs were not looked at.
    """

    distance: Floats
    pair: tuple[tuple[str, str] | None, ...]
    distance_by_class: Mapping[str, Floats]
    pair_by_class: Mapping[str, tuple[tuple[str, str] | None, ...]]
    sample_by_class: Mapping[str, NDArray[np.int64]]
    distance_max: float

    @property
    def worst(self) -> tuple[int, tuple[str, str] | None, float]:
        """Motion with the smallest distance, its pair and the distance in m."""
        motion = int(np.argmin(self.distance))
        return motion, self.pair[motion], float(self.distance[motion])


class CollisionModel:
    """Robot and objects as shapes.

    Pair classes: ``arm-arm``; ``self`` (an arm with itself or the robot's body, links that share a joint excepted);
    ``arm-support`` (what joints move, with immovable objects); ``arm-object`` (with movable objects, the fingers of the
    holding hand excepted); ``object-object`` (movable objects, when one of them is held); ``palm-object`` (the rest of
    the holding hand with what it holds: near by intention, but not inside it). Objects on their supports are not
    compared: they touch by intention. Pairs that the robot's model file excludes stay excluded.

    Attributes:
        robot: the robot.
        shapes: its shapes and those of the objects.
        pairs: (P, 2) shapes that are compared.
        classes: (P,) index of each pair's class in `PAIR_CLASSES`.
    """

    def __init__(
        self, robot: Robot, objects: Mapping[str, ObjectModel], allowed: Collection[tuple[str, str]] = ()
    ) -> None:
        """Prepare the shapes.

        Args:
            robot: the robot, standing where it acts.
            objects: object name in the scene -> its model.
            allowed: pairs of names (robot bodies or objects) that may touch.
        """
        self.robot = robot
        self.shapes = CollisionShapes(robot, objects)
        self.pairs, self.classes = collision_pairs(robot, self.shapes, objects, allowed)
        self._hands = {side: (gripping_bodies(robot, side), hand_bodies(robot, side)) for side in robot.arms}

    def clearances(
        self,
        configurations: ArrayLike,
        T_world_object: Mapping[str, RigidTransform],
        held: Held | None = None,
        distance_max: float = 0.1,
        motions: int | None = None,
        classes: Collection[str] = PAIR_CLASSES,
    ) -> ClearanceReport:
        """Smallest distance by pair class: of every sample, or of every motion over all its samples.

        Args:
            configurations: (B, n) joint positions.
            T_world_object: every object's pose in the world: one, or B of them.
            held: (object, arm) -> (B,) mask of the samples at which that hand's fingers may touch that object.
            distance_max: farther pairs are not looked at, m.
            motions: M, if the samples are those of M motions of equal length, one after the other; default B.
            classes: those of `PAIR_CLASSES` that are looked at; the others are reported as far away.

        Raises:
            ConfigurationError: if the configurations have another shape or are not finite.
            UnknownNameError: if an object's pose is missing, or a held object or an arm is not known.
        """
        position, rotation = self.shapes.poses(configurations, T_world_object)
        samples = len(position)
        count = samples if motions is None else motions
        sample, pair, kind, bound = self._candidates(position, rotation, held, distance_max, classes)
        kinds = len(PAIR_CLASSES)
        cell = sample // max(samples // max(count, 1), 1) * kinds + kind
        least, closest, when = [distance_max] * (count * kinds), [-1] * (count * kinds), [-1] * (count * kinds)
        # nearest bound first: most of the others need no exact distance then
        order = np.lexsort((bound, cell))
        items = zip(*(a[order].tolist() for a in (sample, pair, bound, cell)), strict=True)
        with ExactDistances(self.shapes, position, rotation) as measure:
            for at, which, low, where in items:
                if low < least[where]:
                    distance = measure(at, self.pairs[which], least[where])
                    if distance < least[where]:
                        least[where], closest[where], when[where] = distance, which, at
        smallest, nearest, moment = (np.reshape(values, (count, kinds)) for values in (least, closest, when))
        overall = smallest.argmin(axis=1)
        rows = np.arange(count)
        return ClearanceReport(
            distance=smallest[rows, overall],
            pair=tuple(map(self.names, nearest[rows, overall])),
            distance_by_class={name: smallest[:, index] for index, name in enumerate(PAIR_CLASSES)},
            pair_by_class={name: tuple(map(self.names, nearest[:, i])) for i, name in enumerate(PAIR_CLASSES)},
            sample_by_class={name: moment[:, index] for index, name in enumerate(PAIR_CLASSES)},
            distance_max=distance_max,
        )

    def near(
        self,
        configurations: ArrayLike,
        T_world_object: Mapping[str, RigidTransform],
        held: Held | None = None,
        margin: float = 0.02,
        classes: Collection[str] = PAIR_CLASSES,
    ) -> NearPairs:
        """All pairs of shapes nearer than a margin, with their nearest points; arguments as in `clearances`."""
        position, rotation = self.shapes.poses(configurations, T_world_object)
        sample, pair, kind, _ = self._candidates(position, rotation, held, margin, classes)
        distance, points = np.empty(len(sample)), np.empty((len(sample), 6))
        with ExactDistances(self.shapes, position, rotation) as measure:
            for i in range(len(sample)):
                distance[i] = measure(sample[i], self.pairs[pair[i]], margin)
                points[i] = measure.points
        keep = distance < margin
        sample, pair, kind, distance, points = sample[keep], pair[keep], kind[keep], distance[keep], points[keep]
        first, second = points[:, :3], points[:, 3:]
        scale = np.where(np.abs(distance) > 1e-9, distance, np.inf)
        owners = self.shapes.owner[self.pairs[pair]].reshape(-1, 2)
        return NearPairs(
            sample=sample,
            pair_class=kind,
            first=tuple(self.shapes.owners[i] for i in owners[:, 0]),
            second=tuple(self.shapes.owners[i] for i in owners[:, 1]),
            distance=distance,
            point_first=first,
            point_second=second,
            normal=(first - second) / scale[:, None],
        )

    def _candidates(
        self,
        position: Floats,
        rotation: Floats,
        held: Held | None,
        distance: float,
        classes: Collection[str] = PAIR_CLASSES,
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64], Floats]:
        """Sample, pair, class and lower bound of the distance of what may be near and counts."""
        asked = np.isin(PAIR_CLASSES, list(classes))
        # What a hand has to do with an object is one of two classes, as the hand holds it or not.
        either = ("arm-object", "palm-object")
        maybe = asked | (np.isin(PAIR_CLASSES, either) & any(name in classes for name in either))
        some = np.flatnonzero(maybe[self.classes])
        sample, pair, bound = self.shapes.near(position, rotation, self.pairs[some], distance)
        pair = some[pair]
        keep, kind = self.counting(sample, pair, held or {}, len(position))
        keep &= asked[kind]
        return sample[keep], pair[keep], kind[keep], bound[keep]

    def counting(
        self, sample: NDArray[np.int64], pair: NDArray[np.int64], held: Held, count: int
    ) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
        """Which of N pairs count at which of ``count`` samples, (N,), and their classes, (N,)."""
        owners = self.shapes.owner[self.pairs[pair]].reshape(-1, 2)
        index = {name: i for i, name in enumerate(self.shapes.owners)}
        is_held = np.zeros((count, len(index)), dtype=bool)
        keep = np.ones(len(sample), dtype=bool)
        kind = self.classes[pair]
        for (name, side), mask in held.items():
            body = index[self.shapes.known_object(name)]
            mask = np.asarray(mask, dtype=bool)
            is_held[:, body] |= mask
            if side not in self._hands:
                raise UnknownNameError("arm", side, self._hands, "a held object's arm")
            with_it = mask[sample] & (owners == body).any(axis=1)
            fingers, hand = ([index[link] for link in links if link in index] for links in self._hands[side])
            keep &= ~(with_it & np.isin(owners, fingers).any(axis=1))
            kind[with_it & np.isin(owners, hand).any(axis=1)] = PAIR_CLASSES.index("palm-object")
        loose = ~(is_held[sample, owners[:, 0]] | is_held[sample, owners[:, 1]])
        keep &= ~(loose & (kind == PAIR_CLASSES.index("object-object")))
        return keep, kind

    def names(self, pair: int) -> tuple[str, str] | None:
        """Names of the owners of a pair of shapes, None for -1."""
        if pair < 0:
            return None
        first, second = self.shapes.owner[self.pairs[pair]]
        return self.shapes.owners[first], self.shapes.owners[second]


class ExactDistances:
    """Exact distances of shapes by MuJoCo, in a ``with`` statement; lends its data from the shapes."""

    def __init__(self, shapes: CollisionShapes, position: Floats, rotation: Floats) -> None:
        """Take the positions (B, G, 3) and rotations (B, G, 3, 3) of all shapes."""
        self._shapes, self._geoms = shapes, shapes.geoms
        self._position, self._rotation = position, rotation.reshape(*rotation.shape[:2], 9)
        self.points = np.zeros(6)

    def __enter__(self) -> ExactDistances:
        import mujoco

        self._distance, self._model = mujoco.mj_geomDistance, self._shapes.model
        try:
            self._data = self._shapes.spare_data.pop()
        except IndexError:
            self._data = mujoco.MjData(self._model)
        self._geom_position, self._geom_rotation = self._data.geom_xpos, self._data.geom_xmat
        return self

    def __exit__(self, *_: object) -> None:
        self._shapes.spare_data.append(self._data)

    def __call__(self, sample: int, shapes: NDArray[np.int64], distance_max: float) -> float:
        """Distance of two shapes at a sample, m, at most ``distance_max``; their nearest points are in ``points``."""
        first, second = self._geoms[shapes].tolist()
        for geom, shape in zip((first, second), shapes.tolist(), strict=True):
            self._geom_position[geom] = self._position[sample, shape]
            self._geom_rotation[geom] = self._rotation[sample, shape]
        # Asked for nothing beyond a depth, MuJoCo overlooks greater ones.
        return self._distance(self._model, self._data, first, second, max(distance_max, 0.0), self.points)
