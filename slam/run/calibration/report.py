"""What a calibration found, in a table."""

from __future__ import annotations

from rich.table import Table

from slam.run.calibration.calibrate import Calibration
from slam.run.calibration.wheel_fit import WheelFit


def summary(found: Calibration) -> Table:
    """The factors, what they make of the wheels, and UMBmark's figure before and after."""
    fit = found.fit
    table = Table(box=None, pad_edge=False, show_header=False)
    table.add_column()
    table.add_column(justify="right")
    errors = found.errors
    for name, value, error in (
        ("left wheel, true way per way reported", fit.left, errors.left),
        ("right wheel, the same", fit.right, errors.right),
        ("track, true per believed", fit.track, errors.track),
    ):
        table.add_row(name, f"{value:.5f} +- {2.0 * error:.5f}")
    table.add_row("right wheel to left wheel", f"{fit.right / fit.left:.5f}")
    for name, wheels in (("before", WheelFit()), ("after", fit)):
        table.add_row(f"misses the end of a square, {name}", f"{100.0 * found.worst_closing_error(wheels):.2f} cm")
    return table
