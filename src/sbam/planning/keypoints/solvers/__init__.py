"""Solvers: from a problem and a start to optimised configurations and how they were got."""
