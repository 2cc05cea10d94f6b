"""One fold: learn from some demonstrations, execute where another one began, compare with what the person did there."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field

from sbam.demonstrations.demonstration import Demonstration
from sbam.demonstrations.scenes import scene_from_demonstration
from sbam.errors import BindingError, DemonstrationError, TrajectoryError, UnreachableError
from sbam.evaluation.executed_motion import executed_plan, flight
from sbam.evaluation.metrics import PairDistances, measures, pair_distances
from sbam.evaluation.person import model_anchors, person_motion
from sbam.learning.learn import learn
from sbam.learning.settings import LearningSettings
from sbam.planning.bind import bind
from sbam.planning.plan import plan
from sbam.planning.settings import PlanSettings
from sbam.planning.variant import choose_variant
from sbam.robots import Robot
from sbam.scene import ObjectLibrary

FLYING_HANDS = "flying_hands"
"""Name of the robot without arms: what the action wants, whatever a robot can do."""


@dataclass(frozen=True)
class Condition:
    """How to learn and to plan.

    Attributes:
        name: what the condition is called in tables.
        constraint: constraint type.
        learning: how to learn.
        planning: how to plan.
        robot: name or description file of the robot, or `FLYING_HANDS`.
    """

    name: str
    constraint: str = "cartesian"
    learning: LearningSettings = field(default_factory=LearningSettings)
    planning: PlanSettings = field(default_factory=PlanSettings)
    robot: str = FLYING_HANDS


@dataclass(frozen=True)
class Fold:
    """What is learned from, and what the execution is compared with."""

    training: tuple[Demonstration, ...]
    test: Demonstration


@dataclass(frozen=True)
class FoldResult:
    """What came out of one fold.

    Attributes:
        condition: name of the condition.
        constraint: constraint type.
        robot: name of the robot.
        test: name of the demonstration that was compared with.
        synthetic: whether that demonstration is synthetic.
        training: names of the demonstrations that were learned from.
        synthetic_training: whether any of them is synthetic.
        objects: names of the object models that took part.
        keypoints: their number.
        pairs: distances of all pairs; empty if there was no execution.
        values: other measures, name with unit -> value.
        problems: what is wrong with the execution, or why there is none.
        seconds: stage -> processor time: ``learn``, ``plan``, ``measure``.
    """

    condition: str
    constraint: str
    robot: str
    test: str
    synthetic: bool
    training: tuple[str, ...]
    synthetic_training: bool
    objects: tuple[str, ...]
    keypoints: int
    pairs: tuple[PairDistances, ...]
    values: Mapping[str, float]
    problems: tuple[str, ...]
    seconds: Mapping[str, float]

    @property
    def executed(self) -> bool:
        """Whether there was an execution at all."""
        return bool(self.pairs)


def run_fold(condition: Condition, fold: Fold, robot: Robot | None, library: ObjectLibrary) -> FoldResult:
    """Learn, plan, execute and compare.

    Args:
        condition: how.
        fold: with what.
        robot: the condition's robot; None for `FLYING_HANDS`.
        library: models of the objects.

    Returns:
        The result; a task that could not be learned or planned has no pairs, and problems that say why.

    Raises:
        SbamError: if something is wrong with what was given rather than with the task: unknown names, broken files.
    """
    seconds: dict[str, float] = {}
    pairs: tuple[PairDistances, ...] = ()
    values: dict[str, float] = {}
    keypoints = 0
    objects: tuple[str, ...] = ()
    begin = time.process_time()
    try:
        model = learn(fold.training, condition.constraint, library=library, settings=condition.learning)
        begin = _lap(seconds, "learn", begin)
        scene = scene_from_demonstration(fold.test, library)
        if robot is None:
            variant, _ = choose_variant(model, scene, prune=condition.planning.prune)
            motion = flight(bind(variant, scene), condition.planning)
        else:
            motion = executed_plan(plan(model, scene, robot, condition.planning))
        problems = motion.problems
        objects = tuple(sorted(motion.task.scene.objects[name].name for name in motion.task.binding.values()))
        begin = _lap(seconds, "plan", begin)
        model = motion.task.model  # of the demonstrations that fit the scene
        keypoints = len(model.keypoint_times)
        anchors, training = model_anchors(model), {demonstration.name: demonstration for demonstration in fold.training}
        training = [
            person_motion(training[sketch.name], model, library, anchors, sketch.events)
            for sketch in model.demonstrations
        ]
        person = person_motion(fold.test, model, library, anchors)
        pairs, values = pair_distances(motion, person, training), measures(motion, person)
        _lap(seconds, "measure", begin)
    except (BindingError, DemonstrationError, TrajectoryError, UnreachableError) as error:
        problems = (f"{type(error).__name__}: {error}",)
    return FoldResult(
        condition=condition.name,
        constraint=condition.constraint,
        robot=robot.name if robot else FLYING_HANDS,
        test=fold.test.name,
        synthetic=fold.test.synthetic,
        training=tuple(demonstration.name for demonstration in fold.training),
        synthetic_training=any(demonstration.synthetic for demonstration in fold.training),
        objects=objects,
        keypoints=keypoints,
        pairs=pairs,
        values=values,
        problems=tuple(problems),
        seconds=seconds,
    )


def _lap(seconds: dict[str, float], stage: str, begin: float) -> float:
    now = time.process_time()
    seconds[stage] = now - begin
    return now
