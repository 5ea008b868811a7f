"""A table for the terminal and for a Markdown report."""

from collections.abc import Sequence
from dataclasses import dataclass

from slam.console.terminal_table import TerminalTable


@dataclass(frozen=True, slots=True)
class ResultTable:
    """Rows of text under a title; the first column is a name, the others are numbers."""

    title: str
    columns: Sequence[str]
    """Line ends in them are for the terminal only."""
    rows: Sequence[Sequence[str]]
    notes: str = ""
    """Remarks on the numbers."""

    def for_terminal(self) -> TerminalTable:
        """The table as the terminal shows it."""
        return TerminalTable(self.columns, self.rows, self.title, self.notes)

    def markdown(self) -> str:
        """The table in Markdown, with an empty line at the end."""
        names = [column.replace("\n", " ") for column in self.columns]
        alignment = ["---", *["---:"] * (len(self.columns) - 1)]
        lines = ["| " + " | ".join(row) + " |" for row in (names, alignment, *self.rows)]
        return "\n".join([f"## {self.title}", "", *lines, "", *([self.notes, ""] if self.notes else [])]) + "\n"
