"""Wall time of each stage of planning."""

from __future__ import annotations

import time
from collections.abc import Callable


class Stopwatch:
    """Wall time per stage; one stage ends when the next is entered, and a stage may be entered again."""

    def __init__(self, progress: Callable[[str], None] | None = None) -> None:
        """Begin.

        Args:
            progress: called with the name of each stage as it is entered.
        """
        self._progress = progress
        self._seconds: dict[str, float] = {}
        self._stage, self._since = "", time.perf_counter()

    def enter(self, stage: str) -> None:
        """End the current stage and begin another."""
        self._end()
        self._stage = stage
        if self._progress:
            self._progress(stage)

    def stop(self) -> dict[str, float]:
        """End the current stage; seconds per stage so far."""
        self._end()
        self._stage = ""
        return dict(self._seconds)

    def _end(self) -> None:
        now = time.perf_counter()
        if self._stage:
            self._seconds[self._stage] = self._seconds.get(self._stage, 0.0) + now - self._since
        self._since = now
