"""Finished results in a folder, found again as long as nothing that they depend on has changed."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeVar

import msgspec

from sbam.files import write_atomically

Result = TypeVar("Result")


@dataclass(frozen=True)
class Key:
    """What a result is found by.

    Attributes:
        name: of its file: one result for each name.
        fingerprint: of everything that it depends on, see `sbam.batch.fingerprint`.
    """

    name: str
    fingerprint: str


class _Kept(msgspec.Struct):
    fingerprint: str
    result: msgspec.Raw


@dataclass(frozen=True)
class KeptResults(Generic[Result]):
    """A folder with one JSON file for each result.

    Attributes:
        folder: where they are; None keeps nothing.
        kind: type of the results, as msgspec reads it.
        any_fingerprint: also find results that depended on something else.
    """

    folder: Path | None
    kind: type[Result]
    any_fingerprint: bool = False

    def find(self, key: Key) -> Result | None:
        """The result that was kept; None if there is none, it depended on something else, or its file is damaged."""
        if self.folder is None:
            return None
        try:
            kept = msgspec.json.decode(self._file(self.folder, key).read_bytes(), type=_Kept)
            if self.any_fingerprint or kept.fingerprint == key.fingerprint:
                return msgspec.json.decode(kept.result, type=self.kind)
        except (OSError, msgspec.DecodeError):
            pass
        return None

    def keep(self, key: Key, result: Result) -> None:
        """Write a result; nothing half-written is ever found.

        Raises:
            OutputError: if the file cannot be written.
        """
        if self.folder is not None:
            kept = _Kept(key.fingerprint, msgspec.Raw(msgspec.json.encode(result)))
            write_atomically(self._file(self.folder, key), msgspec.json.encode(kept))

    @staticmethod
    def _file(folder: Path, key: Key) -> Path:
        return folder / f"{key.name}.json"
