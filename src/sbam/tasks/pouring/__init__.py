"""Pouring: from a vessel with ``pour from`` into one with ``pour into``."""
