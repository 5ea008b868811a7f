"""The terminal, or the file or pipe in its place: the one module that makes consoles and progress bars of rich.

Text is printed as it is, character by character: rich's markup would take ``[m]`` for the name of a style.
"""

from __future__ import annotations

import sys
import warnings
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.text import Text

if TYPE_CHECKING:
    from rich.progress import Progress


class Terminal(Console):
    """A console without markup. Long lines are left to the terminal to wrap, so that a copy of one is whole."""

    def __init__(self, **options: Any) -> None:
        """Take the other options of rich's Console."""
        super().__init__(markup=False, emoji=False, highlight=False, soft_wrap=True, **options)

    def waiting(self, text: str) -> AbstractContextManager[object]:
        """A spinner beside the text while the block runs, drawn where ``progress`` draws its bar."""
        if self.quiet or self.is_jupyter:
            return nullcontext()  # rich would show a widget in a notebook
        from rich.live import Live
        from rich.spinner import Spinner

        spinner = Spinner("dots", Text(text), style="status.spinner")
        return Live(
            spinner, console=self._watched(), transient=True, refresh_per_second=12.5,
            redirect_stdout=sys.stdout.isatty(),
        )  # fmt: skip

    def progress(self, *fields: str, transient: bool = False, still: bool = False) -> Progress:
        """A bar between a description and the time; ``fields`` are formats of rich's ``task`` that stand between.

        It is drawn on standard error where standard output is no terminal, and not at all where neither is one. A
        ``still`` one is drawn when it advances only: no thread runs beside what is timed, or forks.
        """
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

        watched = self._watched()
        return Progress(
            TextColumn("{task.description}", markup=False), BarColumn(),
            *(TextColumn(field, markup=False) for field in fields or ("{task.percentage:>3.0f}%",)),
            TimeElapsedColumn(), TextColumn("left"), TimeRemainingColumn(),
            console=watched, disable=not watched.is_terminal or watched.quiet, transient=transient,
            auto_refresh=not still, refresh_per_second=5, speed_estimate_period=300,
            redirect_stdout=sys.stdout.isatty(),
        )  # fmt: skip

    def print_markdown(self, text: str) -> None:
        """Print Markdown in lines of the terminal's width, or of 80 characters."""
        from rich.markdown import Markdown

        self.print(Markdown(text), soft_wrap=False)

    def warn(self, *texts: str) -> None:
        """Print warnings on standard error, a line each; a quiet console makes Python warnings of them."""
        for text in texts:
            if self.quiet:
                warnings.warn(text, stacklevel=3)
            else:
                print(f"hopslam: warning: {text}", file=sys.stderr)

    def _watched(self) -> Console:
        """The console on which a user sees what moves: this one, or standard error."""
        return self if self.is_terminal or self.quiet else Terminal(stderr=True)
