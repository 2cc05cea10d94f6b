"""Evaluation: what an execution is worth."""
