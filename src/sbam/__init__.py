"""SBAM: teach a two-armed robot a task by showing it a few times.

Everything that most programs need, on one screen; each name says in its documentation what it raises.

Example:
    >>> import sbam
    >>> model = sbam.learn(sbam.load("built-in:pouring"), constraint="cylindrical")
    >>> plan = sbam.plan(model, sbam.load_scene("built-in:pouring_new_layout"))
    >>> if plan.ok:
    ...     sbam.write_plan(plan, "out")
    ...     sbam.view(plan, "out/recording.html")
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # what type checkers and editors see; at run time each module is imported when it is first needed
    from sbam.demonstrations.demonstration import Demonstration
    from sbam.demonstrations.loading import load
    from sbam.demonstrations.scenes import scene_from_demonstration
    from sbam.demonstrations.scenes import starting_scene as load_scene
    from sbam.demonstrations.synthetic import built_in_demonstrations
    from sbam.demonstrations.writers import write_demonstration
    from sbam.errors import SbamError
    from sbam.export import write_plan
    from sbam.learning.learn import add_demonstration, learn
    from sbam.learning.model import ActionModel
    from sbam.learning.model_file import load_model, save_model
    from sbam.learning.settings import LearningSettings
    from sbam.planning.placement.search import search_base
    from sbam.planning.plan import Plan, plan
    from sbam.planning.settings import PlanSettings
    from sbam.planning.trajectory.trajectory import JointTrajectory
    from sbam.robots.registry import load_robot
    from sbam.robots.robot import Robot
    from sbam.scene.object_library import ObjectLibrary
    from sbam.scene.scene import Scene
    from sbam.scene.scene_file import save_scene
    from sbam.simulation.simulate import replay, simulate
    from sbam.viewer.recording import write_recording as view

_HOME = {
    # demonstrations
    "load": "sbam.demonstrations.loading",
    "built_in_demonstrations": "sbam.demonstrations.synthetic",
    "write_demonstration": "sbam.demonstrations.writers",
    "Demonstration": "sbam.demonstrations.demonstration",
    # scenes
    "load_scene": "sbam.demonstrations.scenes:starting_scene",
    "save_scene": "sbam.scene.scene_file",
    "scene_from_demonstration": "sbam.demonstrations.scenes",
    "ObjectLibrary": "sbam.scene.object_library",
    "Scene": "sbam.scene.scene",
    # learning
    "learn": "sbam.learning.learn",
    "add_demonstration": "sbam.learning.learn",
    "save_model": "sbam.learning.model_file",
    "load_model": "sbam.learning.model_file",
    "ActionModel": "sbam.learning.model",
    "LearningSettings": "sbam.learning.settings",
    # planning
    "load_robot": "sbam.robots.registry",
    "plan": "sbam.planning.plan",
    "search_base": "sbam.planning.placement.search",
    "Robot": "sbam.robots.robot",
    "Plan": "sbam.planning.plan",
    "PlanSettings": "sbam.planning.settings",
    "JointTrajectory": "sbam.planning.trajectory.trajectory",
    # trying in physics
    "simulate": "sbam.simulation.simulate",
    "replay": "sbam.simulation.simulate",
    # handing on
    "write_plan": "sbam.export",
    "view": "sbam.viewer.recording:write_recording",
    # errors
    "SbamError": "sbam.errors",
}

__all__ = [
    "ActionModel",
    "Demonstration",
    "JointTrajectory",
    "LearningSettings",
    "ObjectLibrary",
    "Plan",
    "PlanSettings",
    "Robot",
    "SbamError",
    "Scene",
    "add_demonstration",
    "built_in_demonstrations",
    "learn",
    "load",
    "load_model",
    "load_robot",
    "load_scene",
    "plan",
    "replay",
    "save_model",
    "save_scene",
    "scene_from_demonstration",
    "search_base",
    "simulate",
    "view",
    "write_demonstration",
    "write_plan",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module, _, original = _HOME[name].partition(":")
    value = getattr(import_module(module), original or name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
