"""Trying a plan or a demonstration in physics."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sbam.demonstrations.demonstration import Demonstration
from sbam.demonstrations.loading import as_demonstration, as_demonstrations
from sbam.planning.plan import Plan
from sbam.scene import ObjectLibrary
from sbam.simulation.action import action_of_demonstration, action_of_plan
from sbam.simulation.arms import FINGER_FORCE
from sbam.simulation.holding import GraspKind
from sbam.simulation.run import World
from sbam.tasks.action import Action
from sbam.tasks.physics_task import PhysicsTask, Values
from sbam.tasks.record import Record
from sbam.tasks.registry import find_task

LARGEST_TRACKING_ERROR = 0.1  # rad or m: beyond it the arms do something else than was planned
LARGEST_SLIP = 0.02  # m: beyond it a held object is torn out of the hand, or slips too far in it
DROPPED = 0.1  # m: beyond it an object is no longer in the hand

Progress = Callable[[float, float], None]


@dataclass(frozen=True)
class SimulationResult:
    """What physics says of an action.

    Attributes:
        action: what was tried.
        task: name of the task it was judged by.
        record: what happened.
        values: what the task measured.
        yardstick: means of the same numbers over the demonstrations; None without demonstrations.
        problems: a sentence for each thing that failed; empty for a success.
        warnings: a sentence for each thing that is not as it should be but did not decide.
        moment: when a failure shows best, s.
        world: the world it happened in, for pictures.
    """

    action: Action
    task: str
    record: Record
    values: Values
    yardstick: Values | None
    problems: tuple[str, ...]
    warnings: tuple[str, ...]
    moment: float
    world: World

    @property
    def ok(self) -> bool:
        """Whether the action succeeds."""
        return not self.problems

    @property
    def speed(self) -> float:
        """Simulated time per processor time."""
        return self.record.simulated / self.record.seconds


def simulate(
    plan: Plan | Action,
    task: PhysicsTask | str | None = None,
    demonstrations: Demonstration | str | Path | Iterable[Demonstration | str | Path] = (),
    yardstick: Values | None = None,
    library: ObjectLibrary | None = None,
    progress: Progress | None = None,
    grasp: GraspKind = "weld",
    grasp_force: float = FINGER_FORCE,
) -> SimulationResult:
    """Let a robot do what was planned, in physics, and judge what comes of it.

    Arms are position-controlled; objects are held rigidly while the plan says so ("grasp assumed"), or by the contact
    of the fingers.

    Args:
        plan: a plan, or an action made of one.
        task: how to judge it, see `sbam.tasks.registry.find_task`.
        demonstrations: what success is measured against: replayed alone, see `yardstick_of`; also files, folders and
            ``built-in:`` names.
        yardstick: what success is measured against, if it is known already.
        library: object models of the demonstrations.
        progress: called with the simulated time and all of it, s.
        grasp: ``weld`` or ``contact``.
        grasp_force: of each finger in contact, N.

    Raises:
        SimulationError: if no task fits, the world cannot be built, the fingers do not move, or the physics becomes
            unstable.
    """
    action = action_of_plan(plan) if isinstance(plan, Plan) else plan
    chosen = find_task(action, task)
    demonstrations = as_demonstrations(demonstrations)
    if yardstick is None and demonstrations:
        yardstick = yardstick_of(demonstrations, chosen, action, library)
    world = World(action, chosen, grasp, grasp_force)
    record = world.run(progress)
    values = chosen.measure(action, record)
    failures, warnings = _execution(record, grasp)
    return SimulationResult(
        action=action,
        task=chosen.name,
        record=record,
        values=values,
        yardstick=yardstick,
        problems=tuple(chosen.judge(values, yardstick) + failures),
        warnings=tuple(warnings),
        moment=_moment(record, action, chosen.moment(values)),
        world=world,
    )


def replay(
    demonstration: Demonstration | str | Path,
    task: PhysicsTask | str | None = None,
    library: ObjectLibrary | None = None,
) -> SimulationResult:
    """Lead the objects of a demonstration along their recorded poses in the same physics.

    Raises:
        SimulationError: if no task fits or the world cannot be built.
        UnknownNameError: if the library lacks an object.
    """
    return simulate(action_of_demonstration(as_demonstration(demonstration), library), task)


def yardstick_of(
    demonstrations: Iterable[Demonstration],
    task: PhysicsTask,
    action: Action | None = None,
    library: ObjectLibrary | None = None,
) -> Values:
    """Means of what the demonstrations do in the same physics.

    Args:
        demonstrations: the demonstrations; of those, the ones with the same moved objects count, if there are any.
        task: how to measure.
        action: what will be compared with them.
        library: their object models.
    """
    demonstrations = list(demonstrations)
    if action is not None:
        demonstrations = comparable(demonstrations, action)
    measured = [replay(demonstration, task, library).values for demonstration in demonstrations]
    numbers = [key for key, value in measured[0].items() if isinstance(value, float)]
    return {key: float(np.mean([values[key] for values in measured if key in values])) for key in numbers} | {
        "demonstrations": [demonstration.name for demonstration in demonstrations]
    }


def comparable(demonstrations: Sequence[Demonstration], action: Action) -> list[Demonstration]:
    """Those that hold the objects that an action moves, or all of them if there are none."""
    moved = {action.scene.objects[name].name for name in action.T_world_object}
    return [one for one in demonstrations if moved <= set(one.objects)] or list(demonstrations)


def _moment(record: Record, action: Action, of_task: float | None) -> float:
    """When the arms or a hand failed first, else what the task says."""
    if max(record.tracking_error.values(), default=0.0) > LARGEST_TRACKING_ERROR:
        return record.worst_tracking
    lost = [
        slip.time[np.argmax(slip.distance > LARGEST_SLIP)] for slip in record.slip.values() if slip.most > LARGEST_SLIP
    ]
    if lost:
        return float(min(lost))
    return 0.5 * action.duration if of_task is None else of_task


def _execution(record: Record, grasp: GraspKind) -> tuple[list[str], list[str]]:
    """What the arms did wrong, and what is worth saying of them."""
    failures, warnings = [], []
    for joint, error in record.tracking_error.items():
        if error > LARGEST_TRACKING_ERROR:
            failures.append(f"{joint} is {error:.2f} rad off its command")
    for (hand, name), slip in record.slip.items():
        if slip.most <= LARGEST_SLIP:
            continue
        when = f"at {slip.time[np.argmax(slip.distance > LARGEST_SLIP)]:.1f} s"
        if grasp == "weld":
            failures.append(f"{name} is torn {1e3 * slip.most:.0f} mm out of the {hand} hand, {when}")
        elif slip.most > DROPPED:
            failures.append(f"the {hand} hand drops {name}, {when}")
        else:
            turned = np.rad2deg(slip.most_angle)
            failures.append(
                f"{name} slips {1e3 * slip.most:.0f} mm and {turned:.0f} degrees in the {hand} hand, {when}"
            )
    for joint, ratio in record.torque_ratio.items():
        if ratio >= 1.0:
            warnings.append(f"{joint} reaches its torque limit")
    for contact in record.contacts:
        warnings.append(
            f"{contact.first} touches {contact.second} from {contact.time:.1f} s for {contact.seconds:.1f} s, "
            f"{1e3 * contact.depth:.1f} mm deep"
        )
    return failures, warnings
