"""Fig. 10: the force of a segment on a point, eq. (24), over their distance."""

from pathlib import Path
from typing import Final

import numpy as np
from matplotlib.figure import Figure
from scipy.optimize import brentq

from slam.run.pictures.figure_style import PAPER, save_figure

GAMMA_F: Final = 1e-4
EPSILON: Final = 1e-4
KAPPA: Final = 3.0
"""The parameters in the caption; section 5.1 then takes ten times this gamma_f."""


def force(distance: float) -> float:
    """Return the force along e_n at a signed distance lambda, metres: eq. (24), for a point beside the segment."""
    return float(GAMMA_F * distance / (abs(distance) ** KAPPA + EPSILON))


def peak() -> float:
    """Return the distance, metres, at which the force is largest: where the derivative of eq. (24) is zero."""
    return float((EPSILON / (KAPPA - 1.0)) ** (1.0 / KAPPA))


def half_width() -> float:
    """Return the distance beyond the peak, metres, at which the force has fallen to half of its maximum."""
    return float(brentq(lambda distance: force(distance) - 0.5 * force(peak()), peak(), 1.0))


def draw(path: Path) -> None:
    """Draw the figure."""
    distances = np.linspace(-0.4, 0.4, 2001)
    figure = Figure(figsize=(7, 4.5), dpi=110, layout="constrained")
    axes = figure.add_subplot()
    axes.axhline(0.0, color="0.8", linewidth=0.8)
    axes.plot(distances, [force(distance) for distance in distances], color=PAPER.slam)
    axes.plot([-peak(), peak()], [force(-peak()), force(peak())], "o", color=PAPER.odometry)
    axes.annotate(f"  {1e3 * peak():.1f} mm, {1e3 * force(peak()):.1f} mm", (peak(), force(peak())))
    axes.set(xlabel="distance lambda [m]", ylabel="force along e_n [m]", title="eq. (24), parameters of Fig. 10")
    save_figure(figure, path)
