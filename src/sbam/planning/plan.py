"""Plan a learned action for a robot in a scene: the main job, from model to verified trajectory."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from sbam.demonstrations.demonstration import Hand
from sbam.errors import TrajectoryError, UnreachableError
from sbam.learning.model import ActionModel
from sbam.planning.grasping.candidates import Grasp
from sbam.planning.grasping.selection import FollowedGrasp, choose_grasps
from sbam.planning.keypoints.free_flight import solve_free_flight
from sbam.planning.keypoints.objective import build_problem, human_likeness_weight
from sbam.planning.keypoints.solvers.result import Solution
from sbam.planning.keypoints.solvers.sequential import solve_sequentially
from sbam.planning.keypoints.solvers.whole_trajectory import solve_whole_trajectory
from sbam.planning.keypoints.unreached import unreached
from sbam.planning.motion.allowed_contacts import collision_model
from sbam.planning.motion.avoidance import keep_clear
from sbam.planning.motion.carrying import Holding, hold_objects
from sbam.planning.motion.motion import Motion, with_approaches
from sbam.planning.motion.object_path import shapes_of
from sbam.planning.motion.timeline import Phase
from sbam.planning.settings import PlanSettings
from sbam.planning.start import start_from
from sbam.planning.task import Task, bind
from sbam.planning.trajectory.limits import Check, check_receivers, failed
from sbam.planning.trajectory.timing import time_path
from sbam.planning.trajectory.trajectory import JointTrajectory
from sbam.planning.trajectory.verification import execute, phase_times
from sbam.robots import Robot, load_robot
from sbam.robots.collision import CollisionModel
from sbam.scene import Scene

Array = NDArray[np.float64]

CHECKPOINTS = 12  # keypoints at which grasps are tried
ATTEMPTS = 20  # combinations of grasps that are carried through to a trajectory before giving up
DEFAULT_ROBOT = "panda_dual"


@dataclass(frozen=True)
class Plan:
    """A planned action.

    Attributes:
        task: the model bound to the scene.
        robot: the robot, standing in the agent frame.
        settings: how it was planned.
        grasps: (role, hand) -> grasp.
        solution: the optimised keypoints.
        free_flight: the same keypoints if no robot had to hold the objects: what the action wants.
        trajectory: the timed joint trajectory.
        clock: (N,) time on the model's axis of every sample, s.
        phases: what each hand does when, on the trajectory's time axis.
        T_agent_object: role -> N poses of every moved object at the trajectory's samples, agent frame.
        checks: what was verified and how it came out.
        problems: a sentence for each thing that is wrong; empty for a plan that may be executed.
        notes: a sentence for each thing that was mended on the way.
        seconds: stage -> wall time.
    """

    task: Task
    robot: Robot
    settings: PlanSettings
    grasps: Mapping[tuple[str, Hand], Grasp]
    solution: Solution
    free_flight: Solution
    trajectory: JointTrajectory
    clock: Array
    phases: tuple[Phase, ...]
    T_agent_object: Mapping[str, RigidTransform]
    checks: tuple[Check, ...]
    problems: tuple[str, ...]
    notes: tuple[str, ...]
    seconds: Mapping[str, float]

    @property
    def ok(self) -> bool:
        """Whether the trajectory passed every check."""
        return not self.problems

    @property
    def T_world_agent(self) -> RigidTransform:
        """The agent frame in the scene's world."""
        return self.task.scene.T_world_agent

    def object_poses(self) -> dict[str, RigidTransform]:
        """Scene's name of every moved object -> N poses at the trajectory's samples, world frame."""
        return {moved.name: self.T_world_agent * self.T_agent_object[moved.role] for moved in self.task.moved}


def plan(
    model: ActionModel,
    scene: Scene,
    robot: Robot | str | None = None,
    settings: PlanSettings | None = None,
    roles: Mapping[str, str] | None = None,
    start: Mapping[str, float] | None = None,
    progress: Callable[[str], None] | None = None,
) -> Plan:
    """Plan a learned action for a two-armed robot in a scene.

    Args:
        model: the Spatial Bimanual Action Model.
        scene: the starting scene, other than in any demonstration; objects bind to roles by their affordances.
        robot: a robot, or the name or description file of one; default the scene's, else the bimanual Panda.
        settings: how to plan.
        roles: role -> object name, where the choice shall not be left to the affordances.
        start: joint name -> position, rad or m, where the robot stands now and returns to; default its home. What is
            outside the limits is projected and noted.
        progress: called with the name of each stage as it begins.

    Returns:
        The plan. Its ``problems`` say what is wrong with it, if anything.

    Raises:
        BindingError: if the scene lacks an object with the affordances a role needs.
        UnreachableError: if the robot cannot do the action; names what stops it.
        UnknownNameError: if the robot, a role, or a joint of the start is not known.
    """
    settings = settings or PlanSettings()
    clock = _Stopwatch(progress)
    clock.enter("bind")
    task = bind(model, scene, roles, settings.prune)
    if not isinstance(robot, Robot):
        robot = load_robot(robot or scene.robot or DEFAULT_ROBOT)
    robot, notes = start_from(robot.placed_for(RigidTransform.identity()), start or {})
    notes = (*task.notes, *notes)
    clock.enter("free flight")
    free, poses = solve_free_flight(task, settings)
    clock.enter("grasps")
    checkpoints = _checkpoints(task)
    at_checkpoints = {role: pose[checkpoints] for role, pose in poses.items()}
    best: Plan | None = None
    aside: tuple[_Attempt, Combination] | None = None
    trouble: UnreachableError | TrajectoryError | None = None
    collision = collision_model(task, robot)
    weight = human_likeness_weight(robot, settings)
    times = task.model.keypoint_times[checkpoints]
    combinations = choose_grasps(task, robot, collision, at_checkpoints, times, settings.seed, weight)
    blocked: set[int] = set()  # grasps whose approach or retreat was
    # The paper's solver takes a minute each time, and its faults do not come from the grasps.
    for chosen in _in_turn(combinations, ATTEMPTS if settings.solver != "paper" else 1, blocked):
        try:
            attempt = _attempt(task, robot, collision, settings, chosen, checkpoints, free, clock)
            if attempt.missed or attempt.clearance < 0.0:  # not worth timing if other grasps do better
                if aside is None or (not attempt.missed, attempt.clearance) > (not aside[0].missed, aside[0].clearance):
                    aside = attempt, chosen
                if attempt.motion and attempt.motion.narrowest and attempt.motion.clearance < 0.0:
                    blocked.add(id(chosen[attempt.motion.narrowest]))
                continue
            candidate = _verified(attempt, task, robot, collision, settings, free, clock, notes)
        except (UnreachableError, TrajectoryError) as error:
            trouble = trouble or error
            continue
        if best is None or len(candidate.problems) < len(best.problems):
            best = candidate
        if best.ok:
            break
    if best is None and aside is not None:
        with suppress(UnreachableError, TrajectoryError):
            attempt = _attempt(task, robot, collision, settings, aside[1], checkpoints, free, clock, anyway=True)
            best = _verified(attempt, task, robot, collision, settings, free, clock, notes)
    if best is None:
        raise trouble or UnreachableError(f"{robot.name} finds no grasps for the whole action")
    return best


@dataclass(frozen=True)
class _Attempt:
    """What one combination of grasps leads to, before it is timed.

    ``missed`` says which keypoints are out of reach, ``clearance`` how much the arms keep beyond the
    distance that is wanted, m. There may be no ``motion`` where something is missed.
    """

    grasps: Mapping[tuple[str, Hand], Grasp]
    solution: Solution
    motion: Motion | None
    missed: tuple[str, ...]
    clearance: float


def _attempt(
    task: Task,
    robot: Robot,
    collision: CollisionModel,
    settings: PlanSettings,
    chosen: Mapping[tuple[str, Hand], FollowedGrasp],
    checkpoints: NDArray[np.int_],
    free: Solution,
    clock: _Stopwatch,
    anyway: bool = False,
) -> _Attempt:
    """Carry one combination of grasps through to a dense motion, ``anyway`` also where keypoints are out of reach."""
    times = task.model.keypoint_times
    grasps = {key: followed.grasp for key, followed in chosen.items()}
    clock.enter("keypoints")
    problem = build_problem(task, robot, {key: grasp.T_object_tcp for key, grasp in grasps.items()}, settings)
    start = np.tile(robot.clip(robot.home), (problem.count, 1))
    for (_, hand), followed in chosen.items():
        for joint in np.flatnonzero(robot.frame_joints(robot.arms[hand].tcp_frame)):
            start[:, joint] = np.interp(np.arange(problem.count), checkpoints, followed.configurations[:, joint])
    if settings.solver == "paper":
        from sbam.planning.keypoints.solvers.nelder_mead import solve_nelder_mead

        solution = solve_nelder_mead(problem, start[0])
    elif settings.solver == "sequential":
        solution = solve_sequentially(problem, start)
    else:
        solution = solve_whole_trajectory(problem, [start])

    between = settings.between or ("lines" if settings.solver == "paper" else "poses")
    shapes = shapes_of(task) if between == "primitive" else {}

    def hold(solution: Solution) -> Holding:
        poses = problem.state(solution.configurations).object_poses()
        joints = between if between in ("lines", "splines") else None
        return hold_objects(task, robot, grasps, times, solution.configurations, poses, joints, shapes)

    missed = tuple(unreached(problem, solution, free, times))
    if missed and not anyway:
        return _Attempt(grasps, solution, None, missed, -np.inf)
    clock.enter("motion")
    holding, clearance = hold(solution), np.inf
    if settings.solver != "paper" and settings.avoid_collisions:
        clock.enter("avoidance")
        solution, holding, clearance = keep_clear(task, robot, collision, problem, solution, holding, hold, settings)
        missed = tuple(unreached(problem, solution, free, times))
        if missed and not anyway:
            return _Attempt(grasps, solution, None, missed, -np.inf)
    clock.enter("motion")
    motion = with_approaches(task, robot, collision, holding, settings.clearance)
    least = min(clearance - settings.clearance, motion.clearance)
    return _Attempt(grasps, solution, motion, missed, least)


def _verified(
    attempt: _Attempt,
    task: Task,
    robot: Robot,
    collision: CollisionModel,
    settings: PlanSettings,
    free: Solution,
    clock: _Stopwatch,
    notes: tuple[str, ...],
) -> Plan:
    """Time a motion and check it."""
    grasps, motion = attempt.grasps, attempt.motion
    assert motion is not None
    clock.enter("timing")
    trajectory, path_time = time_path(robot, motion.clock, motion.configurations, settings.speed, settings.sample_rate)
    clock.enter("checks")
    execution = execute(task, robot, collision, grasps, motion, trajectory, path_time, settings.clearance)
    checks = (*check_receivers(robot, trajectory, robot.clip(robot.home), settings.speed), *execution.checks)
    return Plan(
        task=task,
        robot=robot,
        settings=settings,
        grasps=grasps,
        solution=attempt.solution,
        free_flight=free,
        trajectory=trajectory,
        clock=np.interp(path_time, motion.clock, motion.model_time),
        phases=phase_times(motion, trajectory, path_time),
        T_agent_object=execution.T_agent_object,
        checks=checks,
        problems=(*attempt.missed, *failed(checks)),
        notes=(*notes, *motion.notes),
        seconds=clock.stop(),
    )


Combination = Mapping[tuple[str, Hand], FollowedGrasp]


def _in_turn(combinations: Sequence[Combination], most: int, blocked: set[int]) -> Iterator[Combination]:
    """The best combination, then the best that differ from those tried in as many hands as possible.

    Combinations with a grasp that has turned out to be blocked come after all others.
    """
    left, tried = list(combinations), set()
    for _ in range(min(most, len(left))):
        ids = [[id(item) for item in combination.values()] for combination in left]
        shared = [(len(blocked.intersection(items)), len(tried.intersection(items))) for items in ids]
        choice = min(range(len(left)), key=shared.__getitem__)
        tried.update(ids[choice])
        yield left.pop(choice)


def _checkpoints(task: Task) -> NDArray[np.int_]:
    """Indices of the keypoints at which grasps are tried: evenly from the first lift to the last place."""
    times = task.model.keypoint_times
    first = int(np.searchsorted(times, min(moved.lift for moved in task.moved) + 1e-9)) - 1
    last = int(np.searchsorted(times, max(moved.place for moved in task.moved) - 1e-9))
    return np.unique(np.linspace(max(first, 0), min(last, len(times) - 1), CHECKPOINTS).round().astype(int))


class _Stopwatch:
    """Wall time per stage."""

    def __init__(self, progress: Callable[[str], None] | None) -> None:
        self._progress = progress
        self._seconds: dict[str, float] = {}
        self._stage, self._since = "", time.perf_counter()

    def enter(self, stage: str) -> None:
        """End the current stage and begin another."""
        now = time.perf_counter()
        if self._stage:
            self._seconds[self._stage] = self._seconds.get(self._stage, 0.0) + now - self._since
        self._stage, self._since = stage, now
        if self._progress and stage:
            self._progress(stage)

    def stop(self) -> dict[str, float]:
        """Seconds per stage so far."""
        self.enter("")
        return dict(self._seconds)
