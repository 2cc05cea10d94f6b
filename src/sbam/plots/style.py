"""What all figures share: colours, units, titles, saving."""

from __future__ import annotations

import io
import textwrap
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sbam.errors import UnknownNameError
from sbam.files import write_atomically

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BLUE, ORANGE, GREEN, RED, PURPLE, SKY, YELLOW = (
    "#0072B2",
    "#E69F00",
    "#009E73",
    "#D55E00",
    "#CC79A7",
    "#56B4E9",
    "#F0E442",
)
"""Colours of Okabe and Ito, told apart with every kind of colour vision."""

GREY = "#888888"
LIGHT = "#DDDDDD"
RESOLUTION = 110
"""Dots per inch of pixel pictures."""

LETTERS_PER_INCH = 9.5
"""Of a title."""

FORMATS = (".png", ".pdf", ".svg")

SHOWN: dict[str, tuple[float, str]] = {
    "m": (1000.0, "mm"),
    "rad": (180.0 / np.pi, "deg"),
    "log": (1.0, "log density"),
    "1": (1.0, "1"),
}
"""Unit of a channel -> factor and unit in which it is shown."""


def new_figure(width: float, height: float, title: str, synthetic: bool) -> Figure:
    """An empty figure.

    Args:
        width: inches.
        height: inches.
        title: of the whole figure.
        synthetic: whether what is shown comes from synthetic demonstrations; the title then says so.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    title = f"{title} (synthetic demonstrations)" if synthetic else title
    figure.suptitle(textwrap.fill(title, int(LETTERS_PER_INCH * width)), fontsize=12)
    return figure


def save_figure(figure: Figure, path: str | Path) -> None:
    """Write a figure as PNG, PDF or SVG, as the suffix says.

    Raises:
        UnknownNameError: for another suffix.
        OutputError: if the file cannot be written; nothing half-written is left behind.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        raise UnknownNameError("picture format", suffix, FORMATS, str(path))
    content = io.BytesIO()
    figure.savefig(content, format=suffix[1:], dpi=RESOLUTION)
    write_atomically(path, content.getvalue())
