"""Demonstrations: from recordings of any format to poses of objects and hands on one time axis, events and holds."""

from sbam.demonstrations.readers import read_demonstration, read_demonstrations
from sbam.demonstrations.repair import repair_demonstration
from sbam.demonstrations.resampling import resample
from sbam.demonstrations.synthetic import BUILT_IN_TASKS, built_in_demonstrations
from sbam.demonstrations.writers import write_demonstration

__all__ = [
    "BUILT_IN_TASKS",
    "built_in_demonstrations",
    "read_demonstration",
    "read_demonstrations",
    "repair_demonstration",
    "resample",
    "write_demonstration",
]
