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
    for name, value in (
        ("left wheel, true way per way reported", fit.left),
        ("right wheel, the same", fit.right),
        ("right wheel to left wheel", fit.right / fit.left),
        ("track, true per believed", fit.track),
    ):
        table.add_row(name, f"{value:.5f}")
    for name, wheels in (("before", WheelFit()), ("after", fit)):
        table.add_row(f"misses the end of a square, {name}", f"{100.0 * found.worst_closing_error(wheels):.2f} cm")
    return table
