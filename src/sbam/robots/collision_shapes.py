"""Shapes of the robot and of the scene's objects: where they are, and how near they can possibly be."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.errors import UnknownNameError
from sbam.robots.composition import OBJECT_PREFIX, add_objects, compile_spec
from sbam.robots.robot import Robot
from sbam.scene import ObjectModel

if TYPE_CHECKING:
    import mujoco

Floats = NDArray[np.float64]
ROUNDING = 1e-9  # m^2: squared distances are differences of squares


class CollisionShapes:
    """All shapes in one MuJoCo model, in which every object is a body whose pose is set from outside.

    Attributes:
        model: the MuJoCo model of robot and objects.
        owners: name of each owner of shapes: a robot's body or an object.
        geoms: (G,) shapes' indices in the model; all arrays below follow this order.
        owner: (G,) index of each shape's owner.
        spare_data: MuJoCo data of the model that nobody uses, see `sbam.robots.collision.ExactDistances`.
    """

    def __init__(self, robot: Robot, objects: Mapping[str, ObjectModel]) -> None:
        self._robot = robot
        spec = robot.spec()
        add_objects(spec, objects)
        self.model = compile_spec(spec, robot.description.path)
        model = self.model
        self.spare_data: list[mujoco.MjData] = []
        # shapes that touch nothing (contype = conaffinity = 0) are for drawing only
        self.geoms = np.flatnonzero((model.geom_contype | model.geom_conaffinity) != 0)
        names = [model.body(body).name for body in range(model.nbody)]
        bodies = [names[body] for body in model.geom_bodyid[self.geoms]]
        used = sorted(set(bodies), key=names.index)
        self.robot_bodies = tuple(name for name in used if name in robot.frame_names)
        self.objects = tuple(objects)
        self.owners = self.robot_bodies + self.objects
        index = {name: i for i, name in enumerate(self.robot_bodies)}
        index |= {OBJECT_PREFIX + name: len(index) + i for i, name in enumerate(self.objects)}
        self.owner = np.array([index[body] for body in bodies], dtype=np.int64)
        self._offset = model.geom_pos[self.geoms]
        quaternions = model.geom_quat[self.geoms]
        self._turn = Rotation.from_quat(quaternions, scalar_first=True).as_matrix()
        box = model.geom_aabb[self.geoms]
        self._box_center, self._box_half = box[:, :3], box[:, 3:]
        self._radius = model.geom_rbound[self.geoms]
        self._spine, self._thickness = self._capsules()

    def __getstate__(self) -> dict[str, object]:
        return {**self.__dict__, "spare_data": []}

    def _capsules(self) -> tuple[Floats, Floats]:
        """A capsule around each shape: half its segment (G, 3) from the box's centre, shape's frame, and its radius."""
        import mujoco

        longest = self._box_half.argmax(axis=1)
        half = np.take_along_axis(self._box_half, longest[:, None], axis=1)[:, 0]
        across = np.sqrt(np.maximum((self._box_half**2).sum(axis=1) - half**2, 0.0))
        kind, size = self.model.geom_type[self.geoms], self.model.geom_size[self.geoms]
        round_shapes = np.isin(kind, (int(mujoco.mjtGeom.mjGEOM_CAPSULE), int(mujoco.mjtGeom.mjGEOM_CYLINDER)))
        longest, half = np.where(round_shapes, 2, longest), np.where(round_shapes, size[:, 1], half)
        return half[:, None] * np.eye(3)[longest], np.where(round_shapes, size[:, 0], across)

    def known_object(self, name: str) -> str:
        """The name itself; raises `UnknownNameError` if no object has it."""
        if name not in self.objects:
            raise UnknownNameError("object", name, self.objects, "the collision model")
        return name

    def pose_of(self, name: str, T_world_object: Mapping[str, RigidTransform]) -> RigidTransform:
        """The pose of an object; raises `UnknownNameError` if it is not given."""
        if name not in T_world_object:
            raise UnknownNameError("object", name, T_world_object, "the poses given for a collision check")
        return T_world_object[name]

    def poses(self, configurations: ArrayLike, T_world_object: Mapping[str, RigidTransform]) -> tuple[Floats, Floats]:
        """Positions (B, G, 3) and rotation matrices (B, G, 3, 3) of all shapes in the world.

        Args:
            configurations: (B, n) joint positions.
            T_world_object: every object's pose: one, or B of them.
        """
        kinematics = self._robot.kinematics(configurations, self.robot_bodies)
        count = len(kinematics.position)
        position = np.empty((count, len(self.owners), 3))
        rotation = np.empty((count, len(self.owners), 3, 3))
        fixed = len(self.robot_bodies)
        position[:, :fixed], rotation[:, :fixed] = kinematics.position, kinematics.rotation
        for index, name in enumerate(self.objects, start=fixed):
            pose = self.pose_of(name, T_world_object).as_matrix()
            position[:, index], rotation[:, index] = pose[..., :3, 3], pose[..., :3, :3]
        turn = rotation[:, self.owner]
        return position[:, self.owner] + (turn @ self._offset[..., None])[..., 0], turn @ self._turn

    def near(
        self, position: Floats, rotation: Floats, pairs: NDArray[np.int64], distance: float
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], Floats]:
        """The pairs that may be nearer than a distance; never misses one.

        First bounding spheres, then `lower_bound`.

        Args:
            position: (B, G, 3) of the shapes.
            rotation: (B, G, 3, 3) of the shapes.
            pairs: (P, 2) shapes to compare.
            distance: m.

        Returns:
            Sample (N,), pair (N,) and a lower bound of the distance (N,), m; -inf where they may meet, because the
            depth has no such bound.
        """
        sample, pair = np.nonzero(self.sphere_distance(position, pairs) < distance)
        bound = self.lower_bound(position, rotation, sample, pairs[pair], distance)
        keep = bound < distance
        return sample[keep], pair[keep], bound[keep]

    def sphere_distance(self, position: Floats, pairs: NDArray[np.int64]) -> Floats:
        """Distances (B, P) of the bounding spheres of pairs (P, 2) of shapes at positions (B, G, 3), m."""
        first, second = pairs.T
        centered = position - position.mean(axis=(0, 1)) if position.size else position
        product = centered @ centered.swapaxes(1, 2)
        square = np.einsum("bgg->bg", product)
        apart = square[:, first] + square[:, second] - 2 * product[:, first, second] - ROUNDING
        return np.sqrt(np.maximum(apart, 0.0)) - (self._radius[first] + self._radius[second])

    def levers(self) -> Floats:
        """How far a point of each shape moves at most for a unit of each joint, (G, n) m/rad or m/m."""
        import mujoco

        model = self.model
        levers = np.zeros((len(self.geoms), model.njnt))
        for shape, geom in enumerate(self.geoms):
            reach = float(np.linalg.norm(model.geom_pos[geom]) + model.geom_rbound[geom])
            body = int(model.geom_bodyid[geom])
            while body:
                for joint in range(model.body_jntadr[body], model.body_jntadr[body] + model.body_jntnum[body]):
                    reach += float(np.linalg.norm(model.jnt_pos[joint]))
                    if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_SLIDE:
                        levers[shape, joint] = 1.0
                        reach += float(np.abs(model.jnt_range[joint]).max())
                    else:
                        levers[shape, joint] = reach
                reach += float(np.linalg.norm(model.body_pos[body]))
                body = int(model.body_parentid[body])
        return levers

    def radius_about_origin(self, owner: int) -> float:
        """Largest distance of a point of an owner's shapes from its frame's origin, m."""
        own = self.owner == owner
        return float((np.linalg.norm(self._offset[own], axis=1) + self._radius[own]).max(initial=0.0))

    def lower_bound(
        self,
        position: Floats,
        rotation: Floats,
        sample: NDArray[np.int64],
        shapes: NDArray[np.int64],
        enough: float = np.inf,
    ) -> Floats:
        """Lower bounds (N,) of the distances of pairs of shapes (N, 2) at samples (N,), m; -inf where they may meet.

        The distance of the capsules around both; where that is less than ``enough``, if larger, of each shape's
        bounding box from the other's capsule.
        """
        first, second = shapes.T
        center = position + np.matvec(rotation, self._box_center)
        spine = np.matvec(rotation, self._spine)
        offset = center[sample, first] - center[sample, second]
        bound = _segment_distance(offset, spine[sample, first], spine[sample, second])
        bound -= self._thickness[first] + self._thickness[second]
        near = np.flatnonzero(bound < enough)
        sample, first, second, offset = sample[near], first[near], second[near], offset[near]
        for one, other, towards in ((first, second, -offset), (second, first, offset)):
            turn = rotation[sample, one]
            half = self._box_half[one] + np.abs(np.vecmat(spine[sample, other], turn))
            outside = np.maximum(np.abs(np.vecmat(towards, turn)) - half, 0.0)
            bound[near] = np.maximum(bound[near], np.sqrt(np.vecdot(outside, outside)) - self._thickness[other])
        return np.where(bound > 0.0, bound, -np.inf)


def _segment_distance(offset: Floats, first: Floats, second: Floats) -> Floats:
    """Distance (N,) of segments c1 + s h1 and c2 + t h2, s and t from -1 to 1 (Ericson 2004, section 5.1.9).

    Args:
        offset: (N, 3) c1 - c2.
        first: (N, 3) h1.
        second: (N, 3) h2.
    """
    tiny = 1e-12
    a, b, e = np.vecdot(first, first) + tiny, np.vecdot(first, second), np.vecdot(second, second) + tiny
    c, f = np.vecdot(first, offset), np.vecdot(second, offset)
    s = np.clip((b * f - c * e) / np.maximum(a * e - b * b, tiny), -1.0, 1.0)
    t = np.clip((b * s + f) / e, -1.0, 1.0)
    s = np.clip((b * t - c) / a, -1.0, 1.0)
    between = offset + s[:, None] * first - t[:, None] * second
    return np.sqrt(np.vecdot(between, between))
