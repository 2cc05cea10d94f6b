"""Checks that every figure must pass."""

from collections.abc import Callable, Iterator

import pytest
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text


@pytest.fixture(scope="session")
def assert_readable() -> Callable[[Figure], None]:
    """Draws a figure and checks that no text is cut off and that title and legend lie over no axes."""

    def check(figure: Figure) -> None:
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        renderer = canvas.get_renderer()
        heading = figure._suptitle
        legends = [text for legend in figure.legends for text in legend.get_texts()]
        for text in [heading, *legends, *(text for axes in figure.axes for text in texts_of(axes))]:
            if text.get_visible() and text.get_text().strip():
                box = text.get_window_extent(renderer)
                inside = min(box.x0, box.y0) >= -1 and box.x1 <= figure.bbox.x1 + 1 and box.y1 <= figure.bbox.y1 + 1
                assert inside, f"{text.get_text()!r} is cut off"
        for axes in figure.axes:
            taken = axes.get_tightbbox(renderer)
            assert not heading.get_window_extent(renderer).overlaps(taken), "the title lies over axes"
            for legend in figure.legends:
                assert not legend.get_window_extent(renderer).overlaps(taken), "the legend lies over axes"

    return check


def texts_of(axes: Axes) -> Iterator[Text]:
    """Titles, axis labels and tick labels that are drawn."""
    yield from (axes.title, axes._left_title)
    if not axes.axison:
        return
    for axis in (axes.xaxis, axes.yaxis):
        yield axis.label
        low, high = sorted(axis.get_view_interval())
        yield from (tick.label1 for tick in axis.get_major_ticks() if low <= tick.get_loc() <= high)
