"""A table of plain text for the terminal, a file or a pipe."""

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from textwrap import wrap
from typing import Final, NamedTuple, Self

from rich.box import SIMPLE_HEAD
from rich.cells import cell_len
from rich.console import Console, ConsoleOptions, RenderResult
from rich.table import Table
from rich.text import Text

_GAP: Final = 2
"""Spaces between columns."""
_LONG: Final = 24
"""Length up to which a cell is never wrapped, characters; a longer one is wrapped between words."""


@dataclass(frozen=True, slots=True)
class TerminalTable:
    """Rows of cells under a title; the first column names the row.

    If the columns do not fit side by side on a terminal, the remaining ones follow in another block, beside the names
    again; numbers are never broken. In a file or pipe the table is as wide as necessary.
    """

    columns: Sequence[str]
    """Head of each column; if all are empty, the table has no head."""
    rows: Sequence[Sequence[str]]
    title: str = ""
    notes: str = ""
    bold_rows: int = 0
    """Number of rows, from the first one, that are bold."""

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        available = options.max_width if console.is_terminal else sys.maxsize
        yield from _paragraph(self.title, available, "bold")
        sizes = [_Size.of(cells) for cells in zip(self.columns, *self.rows, strict=True)]
        for number, widths in enumerate(_blocks(sizes, available)):
            if number:
                yield Text()
            width = sum(widths.values()) + _GAP * len(widths)
            yield from console.render(self._block(widths), options.update(width=width, no_wrap=False))
        yield from _paragraph(self.notes, available, "dim")
        if self.title:
            yield Text()

    def _block(self, widths: dict[int, int]) -> Table:
        """Return the columns with these indices, each of this width in characters."""
        headed = any(self.columns)
        table = Table(box=SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, _GAP - 1, 0, 0), show_header=headed)
        for index, width in widths.items():
            numbers = headed and any(row[index][:1].isdigit() or row[index][:1] in {"+", "-"} for row in self.rows)
            table.add_column(Text(self.columns[index]), justify="right" if numbers and index else "left", width=width)
        for number, row in enumerate(self.rows):
            style = "bold" if number < self.bold_rows else ""
            table.add_row(*(Text(row[index]) for index in widths), style=style)
        return table


class _Size(NamedTuple):
    """Widths of a column in characters."""

    least: int
    """Least width that breaks no word and no short cell."""
    whole: int
    """Width that wraps nothing."""
    word: int
    """Width of the longest word."""

    @classmethod
    def of(cls, cells: Sequence[str]) -> Self:
        lines = [line for cell in cells for line in cell.split("\n")]
        whole = max(map(cell_len, lines))
        word = max((cell_len(word) for line in lines for word in line.split()), default=0)
        return cls(min(whole, max(word, _LONG)), whole, word)


def _blocks(sizes: Sequence[_Size], available: int) -> Iterator[dict[int, int]]:
    """Yield widths by the index of the column; every block begins with the first column."""
    names, others = sizes[0], list(enumerate(sizes))[1:]
    least = min(names.least, max(names.word, available - _GAP - max((size.least for _, size in others), default=0)))
    while True:
        room = available - least
        taken: list[tuple[int, _Size]] = []
        while others and (not taken or room >= others[0][1].least + _GAP):
            room -= others[0][1].least + _GAP
            taken.append(others.pop(0))
        yield _widened([(0, names._replace(least=least)), *taken], room)
        if not others:
            return


def _widened(columns: Sequence[tuple[int, _Size]], room: int) -> dict[int, int]:
    """Return widths by index, after the remaining room was given to the columns that can use it, from the left."""
    widths = {}
    for index, size in columns:
        more = max(0, min(size.whole - size.least, room))
        widths[index], room = size.least + more, room - more
    return widths


def _paragraph(text: str, available: int, style: str) -> Iterator[Text]:
    """Split a text of several words into lines; an empty text has none."""
    for line in text.splitlines():
        yield from (Text(part, style) for part in wrap(line, min(available, 10_000)) or [""])
