"""What a writer of recordings is."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from sbam.demonstrations.demonstration import Demonstration


class RecordingWriter(NamedTuple):
    """A format in which recordings can be written.

    Attributes:
        suffix: of its files, lower case, with the dot.
        encode: the content of a demonstration's file.
    """

    suffix: str
    encode: Callable[[Demonstration], bytes]
