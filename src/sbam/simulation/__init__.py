"""Physics: whether a plan does what it shall."""

from sbam.simulation.simulate import SimulationResult, replay, simulate, yardstick_of

__all__ = ["SimulationResult", "replay", "simulate", "yardstick_of"]
