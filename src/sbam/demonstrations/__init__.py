"""Demonstrations."""

from sbam.demonstrations.readers import read_demonstration, read_demonstrations
from sbam.demonstrations.repair import repair
from sbam.demonstrations.resampling import resample
from sbam.demonstrations.writers import write_demonstration

__all__ = ["read_demonstration", "read_demonstrations", "repair", "resample", "write_demonstration"]
