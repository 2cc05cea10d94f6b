"""The way of one arm from home to its grasp past all that stands or moves there; reversed, the way back."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import tee

import numpy as np
from jaxtyping import Bool, Float
from scipy.interpolate import BSpline, make_interp_spline
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.errors import UnreachableError
from sbam.planning.grasping.candidates import Grasp
from sbam.planning.motion.object_path import ease
from sbam.planning.motion.timeline import STEP, lag
from sbam.robots import Robot
from sbam.robots.collision import CollisionModel, Held
from sbam.robots.follow import follow
from sbam.robots.inverse_kinematics import solve_poses

STANDOFF = 0.08  # m from which a grasp is approached in a straight line, and to which the hand retreats
STANDOFFS = (STANDOFF, 0.05, 0.03)  # m: shorter ones where that is out of reach
SAME_POSTURE = 5e-3  # rad: a line that ends farther from the grasp's posture than this ends in another one
LINE_TIME = 0.8  # s of the straight part
TRANSFER_SPEED = 1.0  # rad/s: mean speed of the fastest joint between home and the standoff
AMPLE = 0.02  # m of surplus with which the search for a transfer ends
FINE = np.linspace(0.0, 1.0, 200)
SAMPLES = 25  # configurations of a transfer whose clearance is measured, twice
LINE_SAMPLES = 8  # of the straight part
ENOUGH = 0.005  # m: with less surplus it is tried whether it helps if all else waits
PAYS = 0.001  # m of surplus for which waiting pays
SHARES = (0.25, 0.5, 0.75)  # of the way for which all else waits, before it waits for the whole of it
# Way points of the hand tried between home and the standoff: (up, back along the approach), m.
DETOURS = ((0.10, 0.0), (0.0, 0.10), (0.15, 0.10), (0.25, 0.0))
SPREADS = (0.3, 0.6, 0.9)  # rad: how far random way points are from the middle of the way, where detours do not help
RANDOM = 12  # random way points of each spread


@dataclass(frozen=True)
class Way:
    """Configurations from home to the grasp at equal steps of the clock.

    Attributes:
        transfer: from home to the standoff.
        line: from the standoff straight to the grasp.
        wait: for how many ticks before the grasp all else has to stand still.
        surplus: least distance that was found on it beyond what must be kept, m; up to twice `AMPLE`.
    """

    transfer: Float[np.ndarray, "transfer joints"]
    line: Float[np.ndarray, "line joints"]
    wait: int
    surplus: float

    @property
    def joined(self) -> Float[np.ndarray, "ticks joints"]:
        """The whole way."""
        return np.concatenate([self.transfer, self.line[1:]])


@dataclass(frozen=True)
class Surroundings:
    """What one arm meets on its way.

    Attributes:
        configurations: of the whole robot; the arm's own joints do not count.
        T_agent_object: object name -> pose, or poses of all samples.
        held: (object name, hand) -> when that hand may touch that object.
    """

    configurations: Float[np.ndarray, "samples joints"]
    T_agent_object: Mapping[str, RigidTransform]
    held: Held


# What an arm meets so many ticks before it has to be at its grasp, and on which of them it may touch its object.
Meets = Callable[[Float[np.ndarray, " samples"], Bool[np.ndarray, " samples"]], Surroundings]


def way_to_grasp(
    robot: Robot,
    collision: CollisionModel,
    grasp: Grasp,
    at_grasp: Float[np.ndarray, " joints"],
    meets: Meets,
    clearance: float = 0.0,
) -> Way:
    """Find a way from home to a grasp that keeps clear of what stands around and of the other arm on its way.

    Tried in turn: straight in the joints, over way points of the hand, over random way points near the middle. Where
    none keeps clear, the same while all else stands still, as shortly as possible.

    Args:
        robot: robot standing in the agent frame.
        collision: shapes of the robot and the scene's objects.
        grasp: the grasp.
        at_grasp: configuration that holds it.
        meets: what is around when.
        clearance: distance that must be kept, m.

    Raises:
        UnreachableError: if the straight line to the grasp cannot be followed.
    """
    joints = robot.frame_joints(robot.arms[grasp.hand].tcp_frame)
    options: list[
        tuple[float, Float[np.ndarray, "line joints"], _Passage, _Curve, RigidTransform, Float[np.ndarray, " 3"]]
    ] = []
    for line, standoff, direction in _straight_lines(robot, grasp, at_grasp, STEP):
        home = np.where(joints, robot.clip(robot.home), line[0])
        straight = _Curve(make_interp_spline([0.0, 1.0], np.stack([home, line[0]]), k=1))
        passage = _Passage(robot, collision, joints, line, meets, clearance)
        # More than at its ends no way can have.
        options.append((passage.ends(straight, 1.0), line, passage, straight, standoff, direction))
        if options[-1][0] >= ENOUGH:
            break
    most_waiting, line, passage, straight, standoff, direction = max(options, key=lambda option: option[0])
    curves, again = tee(_curves(robot, grasp, standoff, direction, straight.path(0.0), line[0]))
    most = passage.ends(straight, 0.0)
    hopeless = most < min(ENOUGH, most_waiting - PAYS)
    best, clear = (straight, most) if hopeless else passage.best(curves, most, 0.0)
    if clear >= min(ENOUGH, most_waiting - PAYS):
        return Way(best.configurations(), line, 0, min(clear, most))
    patient, clear_waiting = passage.best(again, most_waiting, 1.0)
    if not hopeless and clear_waiting < clear + PAYS:
        return Way(best.configurations(), line, 0, min(clear, most))
    ticks = patient.ticks + len(line) - 1
    good = min(clear_waiting, AMPLE) - PAYS
    share = next((s for s in SHARES if passage.surplus([patient], s)[0] >= good), 1.0)
    return Way(patient.configurations(), line, round(share * ticks), min(clear_waiting, most_waiting))


class _Curve:
    """A smooth joint path over [0, 1] from home to the standoff, and how many ticks it takes."""

    def __init__(self, path: BSpline) -> None:
        self.path = path
        # How far the joint that travels most travels, rad or m.
        self.travel = float(np.abs(np.diff(path(np.linspace(0.0, 1.0, 100)), axis=0)).sum(axis=0).max())
        self.ticks = max(int(np.ceil(max(self.travel / TRANSFER_SPEED, 0.5) / STEP)), 1)

    def configurations(self) -> Float[np.ndarray, "ticks joints"]:
        """At its ticks, both ends included."""
        return self.path(ease(np.linspace(0.0, 1.0, self.ticks + 1)))


class _Passage:
    """Measures what ways keep beyond a clearance; ``share`` is the share of a way for which all else waits."""

    def __init__(
        self,
        robot: Robot,
        collision: CollisionModel,
        joints: Bool[np.ndarray, " joints"],
        line: Float[np.ndarray, "line joints"],
        meets: Meets,
        clearance: float,
    ) -> None:
        self._clearance = clearance
        self._robot, self._collision, self._joints, self._line, self._meets = robot, collision, joints, line, meets

    def best(self, groups: Iterator[list[_Curve]], most: float, share: float) -> tuple[_Curve, float]:
        """The shortest curve of the first group in which one keeps comfortably clear, or the clearest of all."""
        enough = min(AMPLE, most) - 1e-4
        best, best_surplus = None, -np.inf
        for curves in groups:
            found = self.surplus(curves, share)
            choice = int(np.lexsort(np.stack([[curve.travel for curve in curves], -np.minimum(found, enough)]))[0])
            if found[choice] > best_surplus:
                best, best_surplus = curves[choice], float(found[choice])
            if best_surplus >= enough:
                break
        assert best is not None  # going straight is always possible
        return best, best_surplus

    def ends(self, curve: _Curve, share: float) -> float:
        """Surplus at home, where the curve leaves it, and on the straight line to the grasp, m."""
        total = self._total(curve)
        left = np.linspace(len(self._line) - 1, 0, LINE_SAMPLES).round()
        line = self._measured(self._line[len(self._line) - 1 - left.astype(int)], left, share * total, on_line=True)
        home = self._measured(curve.path(np.zeros(1)), np.array([float(total)]), share * total)
        return float(min(line[0], home[0]))

    def surplus(self, curves: Sequence[_Curve], share: float) -> Float[np.ndarray, " curves"]:
        """Least distances on the curves beyond the clearance, m."""
        # Evenly along the way, for what stands there, and evenly in time, for what moves.
        even = np.linspace(0.0, 1.0, SAMPLES)
        moments = np.sort(np.concatenate([even[1:-1], np.interp(even, ease(FINE), FINE)]))
        shares = ease(moments)
        totals = np.array([self._total(curve) for curve in curves])
        ticks = np.array([curve.ticks for curve in curves])
        left = (1.0 - moments) * ticks[:, None] + len(self._line) - 1
        return self._measured(
            np.concatenate([curve.path(shares) for curve in curves]),
            left.ravel(),
            np.repeat(share * totals, len(shares)),
            motions=len(curves),
        )

    def _total(self, curve: _Curve) -> int:
        return curve.ticks + len(self._line) - 1

    def _measured(
        self,
        configurations: Float[np.ndarray, "samples joints"],
        left: Float[np.ndarray, " samples"],
        wait: Float[np.ndarray, " samples"] | float,
        on_line: bool = False,
        motions: int = 1,
    ) -> Float[np.ndarray, " motions"]:
        """Surplus of each motion, m; ``left`` are the ticks until the grasp, ``wait`` those without all else."""
        meets = self._meets(
            np.where(np.asarray(wait) > 0.0, lag(left - wait), left), np.full(len(configurations), on_line)
        )
        report = self._collision.clearances(
            np.where(self._joints, configurations, meets.configurations),
            meets.T_agent_object,
            meets.held,
            2 * AMPLE + self._clearance,
            motions,
        )
        return (
            np.min([d for kind, d in report.distance_by_class.items() if kind != "palm-object"], axis=0)
            - self._clearance
        )


def _straight_lines(
    robot: Robot, grasp: Grasp, at_grasp: Float[np.ndarray, " joints"], step: float
) -> Iterator[tuple[Float[np.ndarray, "line joints"], RigidTransform, Float[np.ndarray, " 3"]]]:
    """Configurations from a standoff to the grasp, the TCP's pose there, the direction of approach; longest first."""
    frame = robot.kinematics(at_grasp[None], [robot.arms[grasp.hand].tcp_frame])
    T_agent_tcp = RigidTransform.from_components(frame.position[0, 0], Rotation.from_matrix(frame.rotation[0, 0]))
    direction = T_agent_tcp.rotation.apply(np.array(robot.arms[grasp.hand].hand.approach))
    count = round(LINE_TIME / step) + 1
    trouble, found = None, False
    for standoff in STANDOFFS:
        distance = standoff * (1.0 - ease(np.linspace(0.0, 1.0, count)))
        poses = RigidTransform.from_components(
            T_agent_tcp.translation - distance[:, None] * direction, T_agent_tcp.rotation
        )
        try:
            line = follow(robot, grasp.hand, poses, np.tile(at_grasp, (count, 1)), f"to its grasp of {grasp.role!r}")
        except UnreachableError as error:
            trouble = trouble or error
            continue
        gap = at_grasp - line[-1]
        if np.abs(gap).max() < SAME_POSTURE:
            found = True
            yield line + gap, poses[0], direction
    if found:
        return
    raise trouble or UnreachableError(
        f"{robot.name}'s {grasp.hand} hand cannot reach its grasp of {grasp.role!r} in a straight line without another "
        "posture of the arm"
    )


def _curves(
    robot: Robot,
    grasp: Grasp,
    standoff: RigidTransform,
    direction: Float[np.ndarray, " 3"],
    home: Float[np.ndarray, " joints"],
    at_standoff: Float[np.ndarray, " joints"],
) -> Iterator[list[_Curve]]:
    """Smooth joint paths over [0, 1] from home to the standoff, in the order in which they are to be tried."""
    yield [_Curve(make_interp_spline([0.0, 1.0], np.stack([home, at_standoff]), k=1))]
    for detour in DETOURS:
        curve = _detour(robot, grasp, standoff, direction, home, at_standoff, detour)
        if curve is not None:
            yield [curve]
    generator = np.random.default_rng(0)
    joints = robot.frame_joints(robot.arms[grasp.hand].tcp_frame)
    for spread in SPREADS:
        middle = 0.5 * (home + at_standoff)
        points = robot.clip(middle + spread * joints * generator.standard_normal((RANDOM, len(home))))
        curves = [_through(robot, home, point, at_standoff) for point in points]
        if found := [curve for curve in curves if curve is not None]:
            yield found


def _detour(
    robot: Robot,
    grasp: Grasp,
    standoff: RigidTransform,
    direction: Float[np.ndarray, " 3"],
    home: Float[np.ndarray, " joints"],
    at_standoff: Float[np.ndarray, " joints"],
    detour: tuple[float, float],
) -> _Curve | None:
    """Path through a way point of the hand, or None if that is out of reach."""
    up, back = detour
    point = standoff.translation + np.array([0.0, 0.0, up]) - back * direction
    solution = solve_poses(
        robot,
        [grasp.hand],
        point[None, None],
        standoff.rotation.as_matrix()[None, None],
        at_standoff,
        pull=(1e-2, 1e-3),
    )
    return _through(robot, home, solution.configurations[0], at_standoff) if solution.reached()[0] else None


def _through(
    robot: Robot,
    home: Float[np.ndarray, " joints"],
    way_point: Float[np.ndarray, " joints"],
    at_standoff: Float[np.ndarray, " joints"],
) -> _Curve | None:
    """Path through a configuration, or None if it leaves the joint limits."""
    points = np.stack([home, way_point, at_standoff])
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    middle = np.clip(lengths[0] / lengths.sum(), 0.1, 0.9)
    curve = make_interp_spline([0.0, middle, 1.0], points, k=2)
    inside = curve(np.linspace(0.0, 1.0, SAMPLES))
    return _Curve(curve) if (inside >= robot.lower).all() and (inside <= robot.upper).all() else None
