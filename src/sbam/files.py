"""Writing files so that nothing half-written is ever left behind."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from sbam.errors import OutputError


def write_atomically(path: str | Path, data: str | bytes) -> None:
    """Write to a temporary file beside ``path`` and rename it, creating the folder if needed.

    Args:
        path: where the file shall be.
        data: its content; text is written as UTF-8.

    Raises:
        OutputError: if the folder or the file cannot be written (no permission, full disk).
    """
    path = Path(path)
    content = data.encode() if isinstance(data, str) else data
    temporary = ""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        descriptor, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
        with os.fdopen(descriptor, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        umask = os.umask(0)
        os.umask(umask)
        os.chmod(temporary, 0o666 & ~umask)
        os.replace(temporary, path)
    except OSError as error:
        raise OutputError(path, error.strerror or str(error)) from error
    finally:
        if temporary and os.path.exists(temporary):
            os.unlink(temporary)
