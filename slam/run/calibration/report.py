"""What a calibration found, in a table."""

from __future__ import annotations

from slam.console.terminal_table import TerminalTable
from slam.run.calibration.calibrate import Calibration
from slam.run.calibration.wheel_fit import WheelFit


def summary(found: Calibration) -> TerminalTable:
    """The factors, what they make of the wheels, and UMBmark's figure before and after."""
    fit, errors = found.fit, found.errors
    factors = (
        ("left wheel, true way per way reported", fit.left, errors.left),
        ("right wheel, the same", fit.right, errors.right),
        ("track, true per believed", fit.track, errors.track),
    )
    rows = [(name, f"{value:.5f} +- {2.0 * error:.5f}") for name, value, error in factors]
    rows.append(("right wheel to left wheel", f"{fit.right / fit.left:.5f}"))
    for name, wheels in (("before", WheelFit()), ("after", fit)):
        rows.append((f"misses the end of a square, {name}", f"{100.0 * found.worst_closing_error(wheels):.2f} cm"))
    return TerminalTable(("", ""), rows)
