"""How hands hold objects: rigidly, as is assumed, or by the contact of their fingers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, get_args

import numpy as np
from jaxtyping import Bool, Float
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.errors import SimulationError, UnknownNameError
from sbam.robots import Robot
from sbam.robots.collision_pairs import hand_bodies
from sbam.robots.composition import OBJECT_PREFIX, pose_arrays
from sbam.robots.registry import ROBOTS, load_robot
from sbam.simulation.arms import finger_joints
from sbam.tasks.action import Action, Grip
from sbam.tasks.record import Slip

if TYPE_CHECKING:
    import mujoco

GraspKind = Literal["weld", "contact"]
GRASPS: tuple[GraspKind, ...] = get_args(GraspKind)

GRASP = "grasp/"
WELD = (0.006, 1.0)  # time constant, s, and damping ratio of a rigid hold
WELD_IMPEDANCE = (0.95, 0.99, 0.001, 0.5, 2.0)
NO_SLIP = 10  # iterations that keep friction from creeping
FINGER_FRICTION = (1.0, 0.01, 0.0001)  # of rubber pads: sliding; turning about the normal, m; rolling, m


def check_grasp(action: Action, kind: str) -> None:
    """Refuse a kind of grasp that the robot's hands cannot do.

    Raises:
        UnknownNameError: for an unknown kind.
        SimulationError: for contact with hands whose fingers do not move.
    """
    if kind not in GRASPS:
        raise UnknownNameError("grasp", kind, GRASPS, "physics")
    arms = action.arms
    if kind == "contact" and arms is not None and not has_fingers(arms.robot):
        able = [name for name in ROBOTS if has_fingers(load_robot(name))]
        raise SimulationError(
            f"the fingers of {arms.robot.name} do not move, so they cannot hold by contact; "
            f"built-in robots that can: {', '.join(able)}"
        )


def has_fingers(robot: Robot) -> bool:
    """Whether both hands have fingers that open and close."""
    positions = robot.description.locked_joints
    return all(any(positions.get(j, 0.0) for j in finger_joints(robot, hand)) for hand in robot.arms)


def add_grips(spec: mujoco.MjSpec, action: Action, kind: GraspKind) -> None:
    """Mark where each hand holds each object, and add what holds it: a weld, or the friction of the fingers."""
    import mujoco

    assert action.arms is not None
    robot = action.arms.robot
    if kind == "contact":
        spec.option.noslip_iterations = NO_SLIP
    for grip in action.arms.grips:
        position, quaternion_wxyz = pose_arrays(grip.T_object_tcp)
        name = _name(grip)
        spec.body(OBJECT_PREFIX + grip.object).add_site(name=name, pos=position, quat=quaternion_wxyz, group=5)
        tcp = robot.arms[grip.hand].tcp_frame
        if spec.site(tcp) is None:
            spec.body(tcp).add_site(name=f"{tcp}/site", group=5)
            tcp = f"{tcp}/site"
        spec.add_equality(
            name=name,
            type=mujoco.mjtEq.mjEQ_WELD,
            objtype=mujoco.mjtObj.mjOBJ_SITE,
            name1=tcp,
            name2=name,
            active=False,
            solref=list(WELD),
            solimp=list(WELD_IMPEDANCE),
        )
        hand = hand_bodies(robot, grip.hand)
        if kind == "weld":  # what is held by assumption does not collide with the hand
            for body in hand:
                spec.add_exclude(bodyname1=body, bodyname2=OBJECT_PREFIX + grip.object)
        else:
            for body in hand[1:]:
                for geom in spec.body(body).geoms:
                    geom.condim, geom.friction = 4, list(FINGER_FRICTION)


class Holds:
    """Switches the welds, and measures how far each object slips in each hand.

    Args:
        model: the world.
        action: what is done.
        kind: how hands hold. Slip counts from the planned grasp if it is rigid, else from where the object lay in the
            hand when it was lifted.
        times: of all steps, s.
    """

    def __init__(
        self, model: mujoco.MjModel, action: Action, kind: GraspKind, times: Float[np.ndarray, " steps"]
    ) -> None:
        self._kind = kind
        self._holds: list[_Hold] = []
        for grip in action.arms.grips if action.arms else ():
            equality = model.equality(_name(grip))
            sites = int(model.eq_obj1id[equality.id]), int(model.eq_obj2id[equality.id])
            during = (times >= grip.start) & (times <= grip.end)
            self._holds.append(_Hold(grip, int(equality.id), sites, during))

    def switch(self, data: mujoco.MjData, index: int) -> None:
        """Let welds begin and end at a step."""
        if self._kind == "weld":
            for hold in self._holds:
                data.eq_active[hold.equality] = hold.during[index]

    def look(self, data: mujoco.MjData, index: int, time: float) -> None:
        """Note the slip at a step, s."""
        for hold in self._holds:
            if hold.during[index]:
                T_tcp_grasp = _site_pose(data, hold.sites[0]).inv() * _site_pose(data, hold.sites[1])
                if hold.T_tcp_grasp is None:
                    hold.T_tcp_grasp = T_tcp_grasp if self._kind == "contact" else RigidTransform.identity()
                moved = hold.T_tcp_grasp.inv() * T_tcp_grasp
                off = float(np.linalg.norm(T_tcp_grasp.translation - hold.T_tcp_grasp.translation))
                hold.series.append((time, off, float(moved.rotation.magnitude())))

    def slips(self) -> dict[tuple[str, str], Slip]:
        """(hand, object) -> slip."""
        return {(h.grip.hand, h.grip.object): Slip(*np.array(h.series).T) for h in self._holds if h.series}


class _Hold:
    """One grip while it is watched."""

    def __init__(self, grip: Grip, equality: int, sites: tuple[int, int], during: Bool[np.ndarray, " steps"]) -> None:
        self.grip, self.equality, self.sites, self.during = grip, equality, sites, during
        self.T_tcp_grasp: RigidTransform | None = None
        self.series: list[tuple[float, float, float]] = []


def _name(grip: Grip) -> str:
    return f"{GRASP}{grip.hand}/{grip.object}"


def _site_pose(data: mujoco.MjData, site: int) -> RigidTransform:
    return RigidTransform.from_components(
        data.site_xpos[site], Rotation.from_matrix(data.site_xmat[site].reshape(3, 3))
    )
