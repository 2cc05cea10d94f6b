"""Checks that every format needs: time stamps, quaternions, and XML that does no harm."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sbam.errors import FileFormatError

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

Array = NDArray[np.float64]

QUATERNION_TOLERANCE = 0.01
"""Deviation from unit length that rounding can explain."""


def parse_xml(content: bytes, path: Path) -> Element:
    """The root element; entity expansion and external references are refused.

    Raises:
        FileFormatError: if it is not well-formed (line and column), or declares entities.
    """
    import defusedxml.ElementTree
    from defusedxml import DefusedXmlException

    try:
        return defusedxml.ElementTree.fromstring(content)
    except defusedxml.ElementTree.ParseError as error:
        line, column = error.position
        reason = str(error).partition(":")[0]
        raise FileFormatError(
            path, f"line {line}, column {column}", f"not well-formed XML: {reason}", "a complete XML file"
        ) from error
    except DefusedXmlException as error:
        raise FileFormatError(
            path, "", "declares XML entities, which are not read for safety", "XML without a DTD"
        ) from error
    except (ValueError, LookupError) as error:
        raise FileFormatError(path, "", f"not readable as XML: {error}", "XML in UTF-8") from error


def check_time(time: Array, path: Path, where: str) -> None:
    """Raise `FileFormatError` unless time stamps (S,) are finite and strictly increasing."""
    if not np.isfinite(time).all():
        raise FileFormatError(path, f"{where}, frame {int(np.argmin(np.isfinite(time)))}", "time stamp is not a number")
    late = np.flatnonzero(np.diff(time) <= 0)
    if len(late):
        k = int(late[0]) + 1
        raise FileFormatError(
            path,
            f"{where}, frame {k}",
            f"time stamp {time[k]:g} s does not come after {time[k - 1]:g} s",
            "strictly increasing time stamps",
        )


def unit_quaternions(xyzw: Array, path: Path, where: str) -> Array:
    """Quaternions (S, 4) scaled to unit length exactly; rows with NaN stay NaN.

    Raises:
        FileFormatError: if a length deviates by more than `QUATERNION_TOLERANCE`.
    """
    norm = np.linalg.norm(xyzw, axis=1)
    wrong = np.flatnonzero(np.abs(norm - 1.0) > QUATERNION_TOLERANCE)
    if len(wrong):
        k = int(wrong[0])
        raise FileFormatError(path, f"{where}, frame {k}", f"quaternion has length {norm[k]:.4g}", "unit quaternions")
    return xyzw / norm[:, None]
