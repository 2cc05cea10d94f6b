"""Evaluation: what an execution is worth."""

from sbam.evaluation.random_scenes import random_pouring_scene, random_rolling_scene
from sbam.evaluation.task_geometry import Measure, measure_pouring, measure_put_down, measure_rolling

__all__ = [
    "Measure",
    "measure_pouring",
    "measure_put_down",
    "measure_rolling",
    "random_pouring_scene",
    "random_rolling_scene",
]
