"""A table of text and numbers, and how it is written: Markdown, CSV, LaTeX."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from sbam.files import write_atomically

Cell = str | float | None


@dataclass(frozen=True)
class Table:
    """A table of text and numbers.

    Attributes:
        name: short name, for files.
        caption: what the numbers are, and what data they are on.
        columns: headings.
        rows: cells; None where there is no number.
    """

    name: str
    caption: str
    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]

    def markdown(self) -> str:
        """As a Markdown table below its caption."""
        right = [any(isinstance(row[i], float) for row in self.rows) for i in range(len(self.columns))]
        lines = [self.columns, tuple("---:" if one else "---" for one in right), *self._texts()]
        return f"{self.caption}\n\n" + "".join(f"| {' | '.join(line)} |\n" for line in lines)

    def csv(self) -> str:
        """As comma-separated values with full precision, the caption in a comment line."""
        text = io.StringIO()
        text.write(f"# {self.caption}\n")
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(self.columns)
        writer.writerows([["" if cell is None else cell for cell in row] for row in self.rows])
        return text.getvalue()

    def latex(self) -> str:
        """As a LaTeX table (package booktabs)."""
        layout = "".join("r" if any(isinstance(row[i], float) for row in self.rows) else "l" for i in self._indices())
        lines = [" & ".join(map(_escaped, line)) + r" \\" for line in (self.columns, *self._texts())]
        body = "\n".join([r"\toprule", lines[0], r"\midrule", *lines[1:], r"\bottomrule"])
        return (
            f"\\begin{{table}}\n\\caption{{{_escaped(self.caption)}}}\n\\centering\n"
            f"\\begin{{tabular}}{{{layout}}}\n{body}\n\\end{{tabular}}\n\\end{{table}}\n"
        )

    def _indices(self) -> range:
        return range(len(self.columns))

    def _texts(self) -> list[tuple[str, ...]]:
        return [tuple(cell_text(cell) for cell in row) for row in self.rows]


def write_tables(tables: Sequence[Table], folder: Path) -> list[Path]:
    """Write tables as Markdown, CSV and LaTeX; returns the files.

    Raises:
        OutputError: if a file cannot be written.
    """
    files = []
    for table in tables:
        stem = table.name.replace(" ", "_").replace("/", "_")
        for suffix, text in ((".md", table.markdown()), (".csv", table.csv()), (".tex", table.latex())):
            files.append(folder / f"{stem}{suffix}")
            write_atomically(files[-1], text)
    return files


def cell_text(cell: Cell) -> str:
    """A cell as people read it: numbers with one decimal, those below ten with two."""
    if cell is None:
        return "-"
    if isinstance(cell, str):
        return cell
    return f"{cell:.1f}" if abs(cell) >= 10 else f"{cell:.2f}"


def _escaped(text: str) -> str:
    for character in "\\&%$#_{}":
        text = text.replace(character, r"\textbackslash " if character == "\\" else f"\\{character}")
    return text
