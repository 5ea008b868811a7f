"""Look of all pictures: colours, axes, and margins when a figure is saved."""

from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import IO, Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from slam.pose import FloatArray

_DASHES: Final = ("-", "--", ":", "-.")
_MARGIN: Final = 0.1
"""Inches around the drawing."""


@dataclass(frozen=True, slots=True)
class Palette:
    """Colours in matplotlib's form."""

    ink: str = "#1f2328"
    faint: str = "#8b949e"
    grid: str = "#eaecef"
    solid: str = "#e0e0e0"
    """The true walls."""
    edge: str = "#c2c6cb"
    """The edges of the true walls."""
    wall: str = "#1f2328"
    """Mapped walls and segments."""
    point: str = "#b48ead"
    slam: str = "#0072b2"
    odometry: str = "#d55e00"
    truth: str = "#1f2328"
    accent: str = "#8a2be2"
    loop: str = "#009e73"
    """Loops, and final results with all loops closed."""
    doubt: str = "#b0005a"
    """Loops that are not accepted."""

    def curve(self, k: int) -> tuple[str, str]:
        """Return colour and line style of the k-th of several curves on the same axes; twelve are different."""
        return (self.slam, self.odometry, self.accent)[k % 3], _DASHES[k % len(_DASHES)]


PAPER = Palette()
"""Dark on white."""


def figure_size(extent: FloatArray, least: tuple[float, float], room: tuple[float, float]) -> tuple[float, float]:
    """Return the size of a figure, inches: the extent, at least ``least``, plus room for labels and a legend."""
    width, height = (np.maximum(extent, least) + room).tolist()
    return width, height


def save_figure(figure: Figure, file: str | Path | IO[Any], **options: Any) -> None:
    """Write the figure with a margin around it; it grows to include all labels.

    ``options`` are those of ``Figure.savefig``.
    """
    figure.savefig(file, bbox_inches="tight", pad_inches=_MARGIN, **options)


def png_of(figure: Figure, dpi: float = 100.0) -> bytes:
    """Return the figure as the content of a PNG file."""
    file = BytesIO()
    save_figure(figure, file, format="png", dpi=dpi)
    return file.getvalue()


def plain_axes(axes: Axes, colours: Palette) -> None:
    """Draw a light frame and grid, in the colours of the palette."""
    axes.set_facecolor("none")
    axes.grid(color=colours.grid, linewidth=0.6)
    axes.set_axisbelow(True)
    for side, spine in axes.spines.items():
        spine.set_visible(side in ("left", "bottom"))
        spine.set_color(colours.faint)
    axes.tick_params(colors=colours.faint, labelcolor=colours.ink, labelsize=9, length=2.5)
    for label in (axes.xaxis.label, axes.yaxis.label):
        label.set_color(colours.ink)
        label.set_fontsize(9)
    axes.title.set_color(colours.ink)
