"""Demonstrations."""

from sbam.demonstrations.readers import read_demonstration, read_demonstrations
from sbam.demonstrations.repair import repair_demonstration
from sbam.demonstrations.resampling import resample
from sbam.demonstrations.writers import write_demonstration

__all__ = ["read_demonstration", "read_demonstrations", "repair_demonstration", "resample", "write_demonstration"]
