"""Figures written to files, with nothing cut off."""

from __future__ import annotations

from pathlib import Path
from typing import IO, Any, Final

from matplotlib.figure import Figure

_MARGIN: Final = 0.1
"""Inches around all that is drawn."""


def save_figure(figure: Figure, file: str | Path | IO[Any], **options: Any) -> None:
    """Write the figure with a margin around it: it grows by what names and labels stick out of it.

    ``options`` are those of ``Figure.savefig``.
    """
    figure.savefig(file, bbox_inches="tight", pad_inches=_MARGIN, **options)
