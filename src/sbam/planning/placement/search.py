"""Where a robot's base, or the objects, would have to be so that the robot reaches a whole task."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.demonstrations.scenes import as_scene
from sbam.errors import TrajectoryError, UnreachableError
from sbam.learning.model import ActionModel
from sbam.learning.model_file import as_model
from sbam.planning.bind import bind
from sbam.planning.keypoints.free_flight import solve_free_flight
from sbam.planning.placement.reach import HandTargets, Reach, hand_targets, reach_from
from sbam.planning.placement.room import has_room, stay_on_their_supports
from sbam.planning.plan import plan
from sbam.planning.settings import PlanSettings
from sbam.planning.start import standing_robot
from sbam.planning.task import Task
from sbam.planning.variant import choose_variant
from sbam.robots import ObjectHand, Robot
from sbam.robots.options import with_options
from sbam.scene import Scene

RIGHT = np.linspace(-0.4, 0.4, 9)  # m, moves of the base that are tried
FORWARD = np.linspace(-0.5, 0.5, 11)  # m
TURN = np.linspace(-30.0, 30.0, 3)  # degrees, positive to the left
ON_THE_WAY = 9  # places between here and a place that does, among which a nearer one is looked for
TURN_LENGTH = 0.005  # m: a degree of turning counts as much as moving by this
ALL, RANDOM_STARTS = 10_000, 5  # grasps and further starts where the robot stands
TRIED = 3  # places that are planned for, until one does
AS_GOOD = 0.8  # share of the grasps at the end of the way with which a place on it is as good
GOOD_SHARE = 0.25  # share of the best place's grasps with which a place is good enough


@dataclass(frozen=True)
class Place:
    """A move of the base from where it stands, and how the robot reaches from there.

    Attributes:
        right: m, agent frame.
        forward: m, agent frame.
        turn: about its own vertical, to the left, degrees.
        miss: (object, hand) -> how far the hand stays away at its worst moment with its best grasp, m; 0 if it reaches.
        share: of the grasps of the worst hand that reach everywhere.
        planned: whether a plan from there passed all checks; None if it was not tried.
    """

    right: float
    forward: float
    turn: float
    miss: Mapping[ObjectHand, float]
    share: float
    planned: bool | None = None

    @property
    def reaches(self) -> bool:
        """Whether both hands reach."""
        return max(self.miss.values()) == 0.0


@dataclass(frozen=True)
class BaseMap:
    """How a robot reaches a task from the places of a grid.

    Attributes:
        robot: the robot, standing where the search began, agent frame.
        task: the model bound to the scene.
        right: moves of the base, m, agent frame.
        forward: m.
        turn: about its own vertical, to the left, degrees.
        miss: how far the worse hand stays away, m; 0 where both reach.
        share: share of the worse hand's grasps that reach everywhere.
        room: whether what stands of the robot keeps clear of furniture and objects.
        here: where the robot stands.
        base: the nearest place found from which the action can be done, ``here`` if it can be done as it is; None if
            the map holds no place from which both hands reach. If no place that was planned for passed, the nearest one
            all the same: its ``planned`` is False.
        objects: the same for the objects, all together, as the move that **they** make; the robot stays.
    """

    robot: Robot
    task: Task
    right: Float[np.ndarray, " right"]
    forward: Float[np.ndarray, " forward"]
    turn: Float[np.ndarray, " turns"]
    miss: Float[np.ndarray, "turns forward right"]
    share: Float[np.ndarray, "turns forward right"]
    room: Bool[np.ndarray, "turns forward right"]
    here: Place
    base: Place | None
    objects: Place | None


def search_base(
    model: ActionModel | str | Path,
    scene: Scene | str | Path,
    robot: Robot | str | Path | None = None,
    settings: PlanSettings | None = None,
    roles: Mapping[str, str] | None = None,
    progress: Callable[[int, int], None] | None = None,
    *,
    right: Float[np.ndarray, " right"] = RIGHT,
    forward: Float[np.ndarray, " forward"] = FORWARD,
    turn: Float[np.ndarray, " turns"] = TURN,
) -> BaseMap:
    """Search the places around a robot's base for those from which it reaches a whole task.

    The map holds what kinematics allow. The places that are recommended are planned for, with collisions and all.

    Args:
        model: the Spatial Bimanual Action Model, or its file.
        scene: the starting scene, its file, or ``built-in:NAME``.
        robot: a robot, or the name or description file of one; default the scene's, else the bimanual Panda.
        settings: how to plan.
        roles: role -> object name, where the choice shall not be left to the affordances.
        progress: called with how much is done and how much there is.
        right: moves of the base that are tried, m, agent frame.
        forward: m.
        turn: about its own vertical, to the left, degrees; with 0 among them the objects are tried too.

    Raises:
        BindingError: if the scene lacks an object with the affordances a role needs.
        UnreachableError: if an object fits a hand nowhere.
        UnknownNameError: if the robot or a role is not known.
    """
    search = _prepared(model, scene, robot, settings or PlanSettings(), roles)
    task, robot, targets = search.task, search.robot, search.targets
    steps = len(turn) + 2
    say = progress or (lambda done, total: None)
    shape = (len(turn), len(forward), len(right))
    layered = [_moves(right, forward, angle) for angle in turn]
    layers = []
    for done, layer in enumerate(layered):
        say(done, steps)
        layers.append(_measure(robot, targets, layer))
    moves = np.concatenate(layered)
    found = Reach(np.concatenate([r.miss for r in layers]), np.concatenate([r.share for r in layers]))
    room = has_room(robot, task, _bases(robot, moves))
    say(len(turn), steps)
    here = search.checked(search.here())
    base = objects = here
    if not here.planned:
        miss, share = found.miss.max(axis=1), found.share.min(axis=1)
        base = search.best(moves[room], miss[room], share[room], objects=False)
        say(len(turn) + 1, steps)
        straight = (moves[:, 2] == 0) & stay_on_their_supports(task, -moves[:, :2])
        objects = search.best(moves[straight], miss[straight], share[straight], objects=True)
    say(steps, steps)
    return BaseMap(
        robot=robot,
        task=task,
        right=right,
        forward=forward,
        turn=turn,
        miss=found.miss.max(axis=1).reshape(shape),
        share=found.share.min(axis=1).reshape(shape),
        room=room.reshape(shape),
        here=here,
        base=base,
        objects=objects,
    )


def reach_where_it_stands(
    model: ActionModel, scene: Scene, robot: Robot | str | Path | None = None, roles: Mapping[str, str] | None = None
) -> Place:
    """How a robot reaches a whole task from its default place; arguments as in `search_base`.

    It is not planned for: a robot that reaches may still collide, and where a single grasp would do it may be missed.
    """
    return _prepared(model, scene, robot, PlanSettings(), roles).here()


def _prepared(
    model: ActionModel | str | Path,
    scene: Scene | str | Path,
    robot: Robot | str | Path | None,
    settings: PlanSettings,
    roles: Mapping[str, str] | None,
) -> _Search:
    model, scene = as_model(model), as_scene(scene)
    task = bind(choose_variant(model, scene, roles)[0], scene, roles)
    robot = standing_robot(robot, scene)
    _, poses = solve_free_flight(task, settings)
    return _Search(task, robot, settings, poses, hand_targets(task, robot, poses, settings.seed), roles)


@dataclass(frozen=True)
class _Search:
    task: Task
    robot: Robot
    settings: PlanSettings
    poses: Mapping[str, RigidTransform]
    targets: tuple[HandTargets, ...]
    roles: Mapping[str, str] | None

    def here(self) -> Place:
        """Measure where the robot stands, with all grasps and more starts than elsewhere."""
        every = hand_targets(self.task, self.robot, self.poses, self.settings.seed, most=ALL)
        at = np.zeros((1, 3))
        return self._places(at, reach_from(self.robot, every, _bases(self.robot, at), RANDOM_STARTS))[0]

    def places(self, moves: Float[np.ndarray, "moves 3"]) -> list[Place]:
        """Measure moves of the base."""
        return self._places(moves, _measure(self.robot, self.targets, moves))

    def _places(self, moves: Float[np.ndarray, "moves 3"], reach: Reach) -> list[Place]:
        keys = [ObjectHand(self.task.binding[target.role], target.hand) for target in self.targets]
        return [
            Place(*map(float, move), miss=dict(zip(keys, map(float, miss), strict=True)), share=float(share.min()))
            for move, miss, share in zip(moves, reach.miss, reach.share, strict=True)
        ]

    def best(
        self,
        moves: Float[np.ndarray, "moves 3"],
        miss: Float[np.ndarray, " moves"],
        share: Float[np.ndarray, " moves"],
        *,
        objects: bool,
    ) -> Place | None:
        """The nearest place that leaves a comfortable choice of grasps and for which a plan passes all checks."""
        first: Place | None = None
        for tried, move in enumerate(self._in_order(moves, miss, share)):
            if tried == TRIED:
                break
            place = self._nearest_on_the_way(move, objects)
            if objects:
                place = replace(place, right=0.0 - place.right, forward=0.0 - place.forward)
            place = self.checked(place, objects)
            if place.planned:
                return place
            first = first or place
        return first

    def _in_order(
        self, moves: Float[np.ndarray, "moves 3"], miss: Float[np.ndarray, " moves"], share: Float[np.ndarray, " moves"]
    ) -> Iterator[Float[np.ndarray, " 3"]]:
        reached = miss == 0.0
        if not reached.any():
            return
        good = np.flatnonzero(reached & (share >= GOOD_SHARE * share[reached].max()))
        length = np.hypot(np.linalg.norm(moves[good, :2], axis=1), TURN_LENGTH * moves[good, 2])
        yield from moves[good[np.argsort(length, kind="stable")]]

    def _nearest_on_the_way(self, move: Float[np.ndarray, " 3"], objects: bool) -> Place:
        """Halfway from the first place on the straight way that reaches as well as its end, to that end.

        Where a place only just reaches, keypoints are missed and plans fail: hence halfway.
        """
        way = np.linspace(0.0, 1.0, ON_THE_WAY + 2)[:, None] * move
        room = np.ones(len(way), dtype=bool) if objects else has_room(self.robot, self.task, _bases(self.robot, way))
        places = self.places(way)
        good = [
            free and p.reaches and p.share >= AS_GOOD * places[-1].share for p, free in zip(places, room, strict=True)
        ]
        halfway = -(-(good.index(True) + len(way) - 1) // 2)
        return places[halfway] if all(good[halfway:]) else places[-1]

    def checked(self, place: Place, objects: bool = False) -> Place:
        """The place, with the word on whether a plan passes; ``objects``: they have moved instead of the base."""
        scene, robot = self.task.scene, self.robot
        if objects:
            scene = shifted(scene, place.right, place.forward)
        else:
            move = {"right": place.right, "forward": place.forward, "turn": place.turn}
            description = with_options(robot.description, move)
            robot = Robot(description, description.base_in_agent.transform())
        try:
            return replace(place, planned=plan(self.task.model, scene, robot, self.settings, self.roles).ok)
        except (UnreachableError, TrajectoryError):
            return replace(place, planned=False)


def shifted(scene: Scene, right: float, forward: float) -> Scene:
    """The same scene with every movable object moved by the same way, m along the agent's axes."""
    offset = scene.T_world_agent.rotation.apply([right, forward, 0.0])
    move = RigidTransform.from_translation(offset)
    poses = {name: move * pose if scene.objects[name].movable else pose for name, pose in scene.T_world_object.items()}
    return replace(scene, T_world_object=poses)


def _moves(
    right: Float[np.ndarray, " right"], forward: Float[np.ndarray, " forward"], turn: float
) -> Float[np.ndarray, "moves 3"]:
    """Moves of a grid: right m, forward m, turn degrees."""
    y, x = np.meshgrid(forward, right, indexing="ij")
    return np.stack([x.ravel(), y.ravel(), np.full(x.size, turn)], axis=1)


def _bases(robot: Robot, moves: Float[np.ndarray, "moves 3"]) -> RigidTransform:
    """Poses of a robot's base after moves, agent frame."""
    offset = np.column_stack([moves[:, :2], np.zeros(len(moves))])
    turn = Rotation.from_euler("z", moves[:, 2:], degrees=True)
    return RigidTransform.from_components(robot.T_world_base.translation + offset, turn * robot.T_world_base.rotation)


def _measure(robot: Robot, targets: tuple[HandTargets, ...], moves: Float[np.ndarray, "moves 3"]) -> Reach:
    return reach_from(robot, targets, _bases(robot, moves))
