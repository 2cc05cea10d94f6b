"""Plan a learned action for a robot in a scene: the main job, from model to verified trajectory."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import RigidTransform

from sbam.demonstrations.scenes import as_scene
from sbam.learning.model import ActionModel
from sbam.learning.model_file import as_model
from sbam.plain import html_summary
from sbam.planning.bind import bind
from sbam.planning.grasping.candidates import Grasp
from sbam.planning.keypoints.free_flight import solve_free_flight
from sbam.planning.keypoints.solvers.result import Solution
from sbam.planning.keypoints.terms import TermFactory
from sbam.planning.motion.timeline import Phase
from sbam.planning.search import GraspSearch
from sbam.planning.settings import PlanSettings
from sbam.planning.start import standing_robot, start_from
from sbam.planning.stopwatch import Stopwatch
from sbam.planning.task import RoleHand, Task
from sbam.planning.trajectory.limits import Check
from sbam.planning.trajectory.trajectory import JointTrajectory
from sbam.planning.trajectory.verification import phase_times
from sbam.planning.variant import choose_variant
from sbam.robots import Robot
from sbam.scene import Scene


@dataclass(frozen=True)
class Plan:
    """A planned action.

    Attributes:
        task: the model bound to the scene.
        robot: the robot, standing in the scene's world.
        settings: how it was planned.
        grasps: (role, hand) -> grasp.
        solution: the optimised keypoints.
        free_flight: the same keypoints if no robot had to hold the objects: what the action wants.
        trajectory: the timed joint trajectory.
        model_time: time on the model's axis of every sample, s.
        phases: what each hand does when, on the trajectory's time axis.
        T_agent_object: object name -> poses of every moved object at the trajectory's samples, agent frame.
        checks: what was verified and how it came out.
        problems: a sentence for each thing that is wrong; empty for a plan that may be executed.
        notes: a sentence for each thing that was chosen or mended on the way.
        seconds: stage -> wall time.
    """

    task: Task
    robot: Robot
    settings: PlanSettings
    grasps: Mapping[RoleHand, Grasp]
    solution: Solution
    free_flight: Solution
    trajectory: JointTrajectory
    model_time: Float[np.ndarray, " samples"]
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
    def time(self) -> Float[np.ndarray, " samples"]:
        """When the samples of the trajectory are passed, s."""
        return self.trajectory.time

    @property
    def T_world_agent(self) -> RigidTransform:
        """The agent frame in the scene's world."""
        return self.task.scene.T_world_agent

    def object_poses(self) -> dict[str, RigidTransform]:
        """Object name -> poses of every moved object at the trajectory's samples, world frame."""
        return {name: self.T_world_agent * poses for name, poses in self.T_agent_object.items()}

    @property
    def _verdict(self) -> str:
        return f"{len(self.problems)} problems" if self.problems else f"{len(self.checks)} checks passed"

    def __repr__(self) -> str:
        model, scene = self.task.model.name, self.task.scene.name
        duration = self.trajectory.duration
        return f"<Plan of {model!r} in {scene!r} by {self.robot.name}: {duration:.1f} s, {self._verdict}>"

    def _repr_html_(self) -> str:
        rows = {
            "robot": self.robot.name,
            "duration": f"{self.trajectory.duration:.1f} s",
            "verdict": self._verdict,
            "problems": "; ".join(self.problems),
            "notes": "; ".join(self.notes),
            "planned in": f"{sum(self.seconds.values()):.2f} s",
        }
        return html_summary(f"{self.task.model.name} in {self.task.scene.name}", rows)


def plan(
    model: ActionModel | str | Path,
    scene: Scene | str | Path,
    robot: Robot | str | Path | None = None,
    settings: PlanSettings | None = None,
    roles: Mapping[str, str] | None = None,
    start: Mapping[str, float] | None = None,
    progress: Callable[[str], None] | None = None,
    terms: Sequence[TermFactory] = (),
) -> Plan:
    """Plan a learned action for a two-armed robot in a scene.

    Args:
        model: the Spatial Bimanual Action Model, or its file.
        scene: the starting scene, other than in any demonstration, its file, or ``built-in:NAME``; objects bind to
            roles by their affordances.
        robot: a robot, or the name or description file of one; default the scene's, else the bimanual Panda.
        settings: how to plan.
        roles: role -> object name, where the choice shall not be left to the affordances.
        start: joint name -> position, rad or m, where the robot stands now and returns to; default its home. What is
            outside the limits is projected and noted.
        progress: called with the name of each stage as it begins.
        terms: further terms of the objective, beside those of ``settings.terms``: functions that make them for a
            problem. They hold in the free flight too, along which grasps are tried, unless they are about the robot's
            posture; those rank the combinations of grasps that were found.

    Returns:
        The plan. Its ``problems`` say what is wrong with it, if anything.

    Raises:
        BindingError: if the scene lacks an object with the affordances a role needs.
        UnreachableError: if the robot cannot do the action; names what stops it.
        UnknownNameError: if the robot, a role, or a joint of the start is not known.
        FileFormatError: if a file that is given cannot be used.
    """
    model, scene = as_model(model), as_scene(scene)
    settings = settings or PlanSettings()
    settings = replace(settings, terms=(*settings.terms, *terms))
    stopwatch = Stopwatch(progress)
    stopwatch.enter("variant")
    variant, chosen = choose_variant(model, scene, roles, settings.prune)
    stopwatch.enter("bind")
    task = bind(variant, scene, roles)
    standing, projected = start_from(standing_robot(robot, scene), start or {})
    stopwatch.enter("free flight")
    free, free_poses = solve_free_flight(task, settings)
    found = GraspSearch(task, standing, settings, free, free_poses, stopwatch).best()
    motion = found.motion
    return Plan(
        task=task,
        robot=standing.placed_for(scene.T_world_agent),
        settings=settings,
        grasps=found.attempt.grasps,
        solution=found.attempt.solution,
        free_flight=free,
        trajectory=found.trajectory,
        model_time=np.interp(found.clock, motion.clock, motion.model_time),
        phases=phase_times(motion, found.trajectory, found.clock),
        T_agent_object=found.T_agent_object,
        checks=found.checks,
        problems=found.problems,
        notes=(*chosen, *projected, *motion.notes),
        seconds=stopwatch.stop(),
    )
