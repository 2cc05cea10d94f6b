"""Physics: whether a plan does what it shall."""

from sbam.simulation.simulate import SimulationResult, replay, simulate, yardstick_of
from sbam.simulation.tasks import TASKS, Task, find_task, load_task

__all__ = ["TASKS", "SimulationResult", "Task", "find_task", "load_task", "replay", "simulate", "yardstick_of"]
