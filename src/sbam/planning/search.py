"""Search for the grasps with which a robot can do the whole action, up to a verified trajectory."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from scipy.spatial.transform import RigidTransform

from sbam.errors import TrajectoryError, UnreachableError
from sbam.planning.grasping.candidates import Grasp
from sbam.planning.grasping.selection import FollowedGrasp, choose_grasps
from sbam.planning.keypoints.objective import build_problem, posture_cost
from sbam.planning.keypoints.problem import Problem
from sbam.planning.keypoints.solvers.result import Solution
from sbam.planning.keypoints.solvers.sequential import solve_sequentially
from sbam.planning.keypoints.solvers.whole_trajectory import solve_whole_trajectory
from sbam.planning.keypoints.terms.human_likeness import human_likeness_weight
from sbam.planning.keypoints.unreached import unreached
from sbam.planning.motion.allowed_contacts import collision_model
from sbam.planning.motion.avoidance import keep_clear
from sbam.planning.motion.carrying import Holding, hold_objects
from sbam.planning.motion.motion import Motion, with_approaches
from sbam.planning.motion.object_path import shapes_of
from sbam.planning.settings import PlanSettings
from sbam.planning.stopwatch import Stopwatch
from sbam.planning.task import RoleHand, Task
from sbam.planning.trajectory.limits import Check, failed
from sbam.planning.trajectory.timing import time_path
from sbam.planning.trajectory.trajectory import JointTrajectory
from sbam.planning.trajectory.verification import verify
from sbam.robots import Robot

Combination = Mapping[RoleHand, FollowedGrasp]

CHECKPOINTS = 12  # keypoints at which grasps are tried
ATTEMPTS = 20  # combinations of grasps that are carried through to a trajectory before giving up


@dataclass(frozen=True)
class Attempt:
    """What one combination of grasps leads to, before it is timed.

    Attributes:
        combination: the grasps.
        solution: the optimised keypoints.
        unreached: a sentence for each keypoint that is out of reach.
        motion: the dense motion; None if something is out of reach.
        surplus: how much all that must not touch keeps beyond the distance asked for, m; -inf without a motion.
    """

    combination: Combination
    solution: Solution
    unreached: tuple[str, ...]
    motion: Motion | None
    surplus: float

    @property
    def promising(self) -> bool:
        """Whether it is worth timing while others have not been tried."""
        return not self.unreached and self.surplus >= 0.0

    @property
    def grasps(self) -> dict[RoleHand, Grasp]:
        """(role, hand) -> grasp."""
        return {key: followed.grasp for key, followed in self.combination.items()}


@dataclass(frozen=True)
class Candidate:
    """An attempt as a timed and verified trajectory.

    Attributes:
        attempt: the attempt.
        motion: its dense motion.
        trajectory: the timed joint trajectory.
        clock: its samples, the motion's clock, s.
        T_agent_object: object name -> poses of every moved object at the samples, agent frame.
        checks: what was verified and how it came out.
        problems: a sentence for each thing that is wrong.
    """

    attempt: Attempt
    motion: Motion
    trajectory: JointTrajectory
    clock: Float[np.ndarray, " samples"]
    T_agent_object: Mapping[str, RigidTransform]
    checks: tuple[Check, ...]
    problems: tuple[str, ...]


class GraspSearch:
    """Tries combinations of grasps, the best first, until one leads to a trajectory that passes every check.

    1. Grasps are followed along the free flight and combined (`combinations`).
    2. With a combination the keypoints are optimised, what holds objects is kept clear, and the hands are brought from
       home to their grasps and back (`attempt`). What is out of reach or too near is set aside for others.
    3. What is left is timed and verified (`verified`).
    """

    def __init__(
        self,
        task: Task,
        robot: Robot,
        settings: PlanSettings,
        free: Solution,
        free_poses: Mapping[str, RigidTransform],
        stopwatch: Stopwatch,
    ) -> None:
        """Prepare the search.

        Args:
            task: model bound to a scene.
            robot: robot standing in the agent frame.
            settings: how to plan.
            free: the keypoints of the free flight.
            free_poses: role -> poses at them, agent frame.
            stopwatch: told of each stage.
        """
        self._task, self._robot, self._settings = task, robot, settings
        self._free, self._free_poses, self._stopwatch = free, free_poses, stopwatch
        self._collision = collision_model(task, robot)
        self._checkpoints = _checkpoints(task)
        self._blocked: set[FollowedGrasp] = set()  # whose approach or retreat turned out to be blocked

    def best(self) -> Candidate:
        """The first candidate without a problem, or the one with the fewest.

        Raises:
            UnreachableError: if no combination leads to a motion; says what stops the first.
            TrajectoryError: if no motion can be timed.
        """
        best: Candidate | None = None
        aside: Attempt | None = None
        trouble: UnreachableError | TrajectoryError | None = None
        for combination in self.combinations():
            try:
                attempt = self.attempt(combination)
                if not attempt.promising:
                    aside = _better(aside, attempt)
                    self._remember_blocked(attempt)
                    continue
                candidate = self.verified(attempt)
            except (UnreachableError, TrajectoryError) as error:
                trouble = trouble or error
                continue
            if best is None or len(candidate.problems) < len(best.problems):
                best = candidate
            if not best.problems:
                return best
        if best is None and aside is not None:
            with suppress(UnreachableError, TrajectoryError):
                best = self.verified(self.attempt(aside.combination, anyway=True))
        if best is None:
            raise trouble or UnreachableError(f"{self._robot.name} finds no grasps for the whole action")
        return best

    def combinations(self) -> Iterator[Combination]:
        """The best combination, then the best that differ from those tried in as many hands as possible.

        Combinations with a grasp that has turned out to be blocked come after all others.
        """
        self._stopwatch.enter("grasps")
        times = self._task.model.keypoint_times[self._checkpoints]
        left = list(
            choose_grasps(
                self._task,
                self._robot,
                self._collision,
                {role: poses[self._checkpoints] for role, poses in self._free_poses.items()},
                times,
                self._settings.seed,
                human_likeness_weight(self._robot, self._settings),
                posture_cost(self._task, self._robot, self._settings, times),
            )
        )
        # The paper's solver takes a minute each time, and its faults do not come from the grasps.
        most = ATTEMPTS if self._settings.solver != "paper" else 1
        tried: set[FollowedGrasp] = set()

        def shared(combination: Combination) -> tuple[int, int]:
            return len(self._blocked.intersection(combination.values())), len(tried.intersection(combination.values()))

        for _ in range(min(most, len(left))):
            choice = min(range(len(left)), key=lambda index: shared(left[index]))
            tried.update(left[choice].values())
            yield left.pop(choice)

    def attempt(self, combination: Combination, anyway: bool = False) -> Attempt:
        """Carry one combination of grasps through to a dense motion.

        Args:
            combination: the grasps.
            anyway: also where keypoints are out of reach.

        Raises:
            UnreachableError: if the dense motion cannot be followed or a grasp cannot be approached.
        """
        task, robot, settings = self._task, self._robot, self._settings
        times = task.model.keypoint_times
        grasps = {key: followed.grasp for key, followed in combination.items()}
        self._stopwatch.enter("keypoints")
        problem = build_problem(task, robot, {key: grasp.T_object_tcp for key, grasp in grasps.items()}, settings)
        solution = self._optimized(problem, combination)
        between = settings.between or ("lines" if settings.solver == "paper" else "poses")
        shapes = shapes_of(task) if between == "primitive" else {}

        def hold(solution: Solution) -> Holding:
            poses = problem.state(solution.configurations).object_poses()
            joints = between if between in ("lines", "splines") else None
            return hold_objects(task, robot, grasps, times, solution.configurations, poses, joints, shapes)

        missed = tuple(unreached(problem, solution, self._free, times))
        if missed and not anyway:
            return Attempt(combination, solution, missed, None, -np.inf)
        self._stopwatch.enter("motion")
        holding, kept = hold(solution), np.inf
        if settings.solver != "paper" and settings.avoid_collisions:
            self._stopwatch.enter("avoidance")
            solution, holding, kept = keep_clear(
                task, robot, self._collision, problem, solution, holding, hold, settings
            )
            missed = tuple(unreached(problem, solution, self._free, times))
            if missed and not anyway:
                return Attempt(combination, solution, missed, None, -np.inf)
            self._stopwatch.enter("motion")
        motion = with_approaches(task, robot, self._collision, holding, settings.clearance)
        return Attempt(combination, solution, missed, motion, min(kept - settings.clearance, motion.surplus))

    def verified(self, attempt: Attempt) -> Candidate:
        """Time an attempt's motion and check it.

        Raises:
            UnreachableError: if the attempt has no motion.
            TrajectoryError: if no timing keeps the robot's limits.
        """
        task, robot, settings, motion = self._task, self._robot, self._settings, attempt.motion
        if motion is None:
            raise UnreachableError("; ".join(attempt.unreached))
        self._stopwatch.enter("timing")
        trajectory, clock = time_path(robot, motion.clock, motion.configurations, settings.speed, settings.sample_rate)
        self._stopwatch.enter("checks")
        T_agent_object, checks = verify(
            task, robot, self._collision, attempt.grasps, motion, trajectory, clock, settings.clearance, settings.speed
        )
        problems = (*attempt.unreached, *failed(checks))
        return Candidate(attempt, motion, trajectory, clock, T_agent_object, checks, problems)

    def _optimized(self, problem: Problem, combination: Combination) -> Solution:
        """The keypoints, optimised from the postures in which the grasps were followed."""
        robot = self._robot
        start = np.tile(robot.clip(robot.home), (problem.count, 1))
        for key, followed in combination.items():
            for joint in np.flatnonzero(robot.frame_joints(robot.arms[key.hand].tcp_frame)):
                start[:, joint] = np.interp(
                    np.arange(problem.count), self._checkpoints, followed.configurations[:, joint]
                )
        if self._settings.solver == "paper":
            from sbam.planning.keypoints.solvers.nelder_mead import solve_nelder_mead

            return solve_nelder_mead(problem, start[0])
        if self._settings.solver == "sequential":
            return solve_sequentially(problem, start)
        return solve_whole_trajectory(problem, [start])

    def _remember_blocked(self, attempt: Attempt) -> None:
        if attempt.motion and attempt.motion.narrowest and attempt.motion.surplus < 0.0:
            self._blocked.add(attempt.combination[attempt.motion.narrowest])


def _better(one: Attempt | None, other: Attempt) -> Attempt:
    """Which of two attempts that are not promising is nearer to being so."""
    if one is None:
        return other
    return other if (not other.unreached, other.surplus) > (not one.unreached, one.surplus) else one


def _checkpoints(task: Task) -> Int[np.ndarray, " checkpoints"]:
    """Indices of the keypoints at which grasps are tried: evenly from the first lift to the last place."""
    times = task.model.keypoint_times
    first = int(np.searchsorted(times, min(moved.lift for moved in task.moved) + 1e-9)) - 1
    last = int(np.searchsorted(times, max(moved.place for moved in task.moved) - 1e-9))
    return np.unique(np.linspace(max(first, 0), min(last, len(times) - 1), CHECKPOINTS).round().astype(int))
