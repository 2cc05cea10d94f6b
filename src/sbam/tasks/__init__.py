"""What a pour and a roll are: their geometry, random scenes, faults, and success in physics.

Each task is a folder: ``geometry`` says what must be true of the objects' motion, ``scenes`` where they may stand,
``physics`` what is added to the world and what must come of it. A task of your own needs only the last.
"""

from sbam.tasks.geometry import GeometryResult, measure_put_down
from sbam.tasks.physics_task import PhysicsTask, Values
from sbam.tasks.pouring.geometry import measure_pouring
from sbam.tasks.pouring.scenes import random_pouring_scene
from sbam.tasks.registry import TASKS, find_task, load_task
from sbam.tasks.rolling.geometry import measure_rolling
from sbam.tasks.rolling.scenes import random_rolling_scene

__all__ = [
    "TASKS",
    "GeometryResult",
    "PhysicsTask",
    "Values",
    "find_task",
    "load_task",
    "measure_pouring",
    "measure_put_down",
    "measure_rolling",
    "random_pouring_scene",
    "random_rolling_scene",
]
