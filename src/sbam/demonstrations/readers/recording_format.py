"""What a reader of recordings is."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from sbam.demonstrations.recording import Recording


class RecordingFormat(NamedTuple):
    """A format of recordings: how its files are recognised and read.

    Attributes:
        name: of the format, for messages.
        suffix: of its files, lower case, with the dot.
        recognises: whether a file's content is of this format; it must not raise.
        read: the recording in a file's content; raises `sbam.errors.FileFormatError` that says where and what was
            expected.
    """

    name: str
    suffix: str
    recognises: Callable[[bytes], bool]
    read: Callable[[bytes, Path], Recording]
