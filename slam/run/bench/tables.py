"""A table for the terminal and for a Markdown report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from rich.box import SIMPLE_HEAD
from rich.table import Table


@dataclass(frozen=True, slots=True)
class ResultTable:
    """Rows of text under a title; the first column is a name, the others are numbers."""

    title: str
    columns: Sequence[str]
    """Line ends in them are for the terminal only."""
    rows: Sequence[Sequence[str]]
    notes: str = ""
    """What to know about the numbers."""

    def rich(self) -> Table:
        """For the terminal."""
        table = Table(
            title=self.title, title_justify="left", caption=self.notes, caption_justify="left",
            box=SIMPLE_HEAD, padding=(0, 1, 0, 0),
        )  # fmt: skip
        for index, column in enumerate(self.columns):
            table.add_column(column, justify="right" if index else "left", no_wrap=not index, overflow="fold")
        for row in self.rows:
            table.add_row(*row)
        return table

    def markdown(self) -> str:
        """For a report, with an empty line at the end."""
        names = [column.replace("\n", " ") for column in self.columns]
        alignment = ["---", *["---:"] * (len(self.columns) - 1)]
        lines = ["| " + " | ".join(row) + " |" for row in (names, alignment, *self.rows)]
        return "\n".join([f"## {self.title}", "", *lines, "", *([self.notes, ""] if self.notes else [])]) + "\n"
