"""A table for the terminal, for a Markdown report and for a notebook."""

from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup

from slam.console.terminal_table import TerminalTable


@dataclass(frozen=True, slots=True)
class ResultTable:
    """Rows of text under a title; the first column is a name, the others are numbers."""

    title: str
    columns: Sequence[str]
    """Heads of the columns; line ends in them are for the terminal only."""
    rows: Sequence[Sequence[str]]
    notes: str = ""
    """Remarks on the numbers."""

    def for_terminal(self) -> TerminalTable:
        """Format the table for a terminal."""
        return TerminalTable(self.columns, self.rows, self.title, self.notes)

    def html(self) -> str:
        """Format the table as HTML, with its title above it."""
        lines = Markup("").join([_line("th", self.columns), *(_line("td", row) for row in self.rows)])
        title = Markup("<p><b>{}</b></p>").format(self.title) if self.title else Markup("")
        return str(title + Markup("<table>{}</table>").format(lines))

    def markdown(self) -> str:
        """Format the table as Markdown, with an empty line at the end."""
        names = [column.replace("\n", " ") for column in self.columns]
        alignment = ["---", *["---:"] * (len(self.columns) - 1)]
        lines = ["| " + " | ".join(row) + " |" for row in (names, alignment, *self.rows)]
        return "\n".join([f"## {self.title}", "", *lines, "", *([self.notes, ""] if self.notes else [])]) + "\n"


def _line(tag: str, cells: Sequence[str]) -> Markup:
    """Format a line of a table as HTML, with this kind of cells."""
    return Markup("<tr>{}</tr>").format(Markup("").join(Markup(f"<{tag}>{{}}</{tag}>").format(cell) for cell in cells))
