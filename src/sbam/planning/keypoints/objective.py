"""Build the optimisation problem of a task for a robot that holds its objects."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import RigidTransform

from sbam.demonstrations.demonstration import Hand
from sbam.errors import SettingsError
from sbam.extensions import BUILT_IN
from sbam.planning.keypoints.problem import Problem
from sbam.planning.keypoints.state import Carrying, RegionPoint, Workspace
from sbam.planning.keypoints.terms import TERMS, Term, TermContext, TermFactory
from sbam.planning.settings import PlanSettings
from sbam.planning.task import Task
from sbam.robots import Robot

Grasps = Mapping[tuple[str, Hand], RigidTransform]


def build_problem(
    task: Task,
    robot: Robot,
    T_object_tcp: Grasps,
    settings: PlanSettings,
    times: Float[np.ndarray, " keypoints"] | None = None,
    free_flight: bool = False,
) -> Problem:
    """The problem of bringing a task's objects through its keypoints.

    Its terms are the built-in ones and those of ``settings.terms``; each decides whether it has anything to say.

    Args:
        task: model bound to a scene.
        robot: a robot standing in the agent frame.
        T_object_tcp: (role, hand) -> grasp.
        settings: weights of the terms, and further terms.
        times: keypoints on the model's time axis, s; default the model's own.
        free_flight: leave out what is about the posture of a robot.

    Returns:
        The problem; its workspace's carryings are in the order of ``task.moved``.

    Raises:
        UnknownNameError: if no term has a name of ``settings.terms``.
        ExtensionError: if a term that another distribution registers cannot be used.
        SettingsError: if something in ``settings.terms`` makes no terms.
    """
    context = _context(task, robot, T_object_tcp, settings, times, free_flight)
    factories = [*(TERMS[name] for name in BUILT_IN["sbam.terms"]), *_further(settings)]
    terms = tuple(
        term for make in factories for term in _made(make, context) if not (free_flight and term.about_posture)
    )
    return Problem(_workspace(context, terms), terms, len(context.times))


def posture_cost(
    task: Task, robot: Robot, settings: PlanSettings, times: Float[np.ndarray, " moments"]
) -> Callable[[Grasps, Float[np.ndarray, "moments joints"]], float] | None:
    """What further terms about the robot's posture say of grasps; None if there are no further terms.

    Args:
        task: model bound to a scene.
        robot: a robot standing in the agent frame.
        settings: further terms.
        times: moments on the model's time axis, s.

    Returns:
        From the grasps of all hands and the configurations at the moments to the mean cost of these terms.
    """
    factories = list(_further(settings))
    if not factories:
        return None

    def cost(T_object_tcp: Grasps, configurations: Float[np.ndarray, "moments joints"]) -> float:
        context = _context(task, robot, T_object_tcp, settings, times, free_flight=False)
        terms = tuple(term for make in factories for term in _made(make, context) if term.about_posture)
        state = _workspace(context, terms).state(configurations)
        return float(sum(term.cost(state).sum() for term in terms)) / len(times)

    return cost


def _further(settings: PlanSettings) -> Iterator[TermFactory]:
    """What the settings add to the built-in terms."""
    for term in settings.terms:
        if not isinstance(term, str):
            yield term
        elif term not in BUILT_IN["sbam.terms"]:
            yield TERMS[term]


def _made(make: TermFactory, context: TermContext) -> Iterator[Term]:
    terms = make(context)
    if isinstance(terms, Term):
        raise SettingsError("terms", make, "a function of a TermContext that returns a list of terms, not one term")
    for term in terms:
        if not isinstance(term, Term):
            raise SettingsError("terms", make, f"a function of a TermContext that returns terms, not {term!r}")
        yield term


def _context(
    task: Task,
    robot: Robot,
    T_object_tcp: Grasps,
    settings: PlanSettings,
    times: Float[np.ndarray, " keypoints"] | None,
    free_flight: bool,
) -> TermContext:
    regions = {region for c in task.model.changes for region in (c.pair.first, c.pair.second) if region is not None}
    return TermContext(
        task=task,
        robot=robot,
        T_object_tcp=T_object_tcp,
        regions=tuple(sorted(regions)),
        times=task.model.keypoint_times if times is None else times,
        settings=settings,
        free_flight=free_flight,
    )


def _workspace(context: TermContext, terms: tuple[Term, ...]) -> Workspace:
    """The robot with what it carries, and every frame that a term looks at."""
    task, roles = context.task, context.roles
    carryings = [
        Carrying(moved.role, moved.hands[0], context.T_object_tcp[moved.role, moved.hands[0]].inv())
        for moved in task.moved
    ]
    points = [
        RegionPoint(roles.index(region.role), task.region_center(region))
        if region.role in roles
        else RegionPoint(-1, task.region_at_start(region))
        for region in context.regions
    ]
    frames = tuple(dict.fromkeys(frame for term in terms for frame in term.frames))
    return Workspace(context.robot, carryings, points, frames)
