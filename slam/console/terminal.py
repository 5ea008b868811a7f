"""Output to a terminal, a file or a pipe; the only module that makes rich's consoles and progress bars.

Text is printed unchanged: rich's markup would read ``[m]`` as the name of a style.
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
    """A console without markup. It does not wrap long lines, so that a copied line is complete."""

    def __init__(self, **options: Any) -> None:
        """Pass the other options to rich's Console."""
        super().__init__(markup=False, emoji=False, highlight=False, soft_wrap=True, **options)

    def waiting(self, text: str) -> AbstractContextManager[object]:
        """Show a spinner beside the text while the block runs, on the stream that ``progress`` uses."""
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
        """Make a progress bar with a description on its left, and ``fields`` and the time on its right.

        ``fields`` are format strings for rich's ``task``. The bar is drawn on standard error if standard output is not
        a terminal, and not at all if neither is. A ``still`` bar is drawn only when it advances: no extra thread
        disturbs timing or forks.
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
        """Print warnings on standard error, one per line; a quiet console turns them into Python warnings."""
        for text in texts:
            if self.quiet:
                warnings.warn(text, stacklevel=3)
            else:
                print(f"hopslam: warning: {text}", file=sys.stderr)

    def _watched(self) -> Console:
        """The console for progress: this one, or standard error."""
        return self if self.is_terminal or self.quiet else Terminal(stderr=True)
