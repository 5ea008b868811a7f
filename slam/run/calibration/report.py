"""Results of a calibration: a table, a picture of the squares, and a scenario with the calibrated wheels."""

from pathlib import Path

import yaml
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from slam.console.terminal_table import TerminalTable
from slam.files.atomic_files import atomic_file, require_writable, write_atomic
from slam.pose import FloatArray, Pose2D
from slam.run.calibration.calibrate import Calibration, wheel_settings
from slam.run.calibration.wheel_fit import WheelFit, corrected
from slam.run.pictures.figure_style import PAPER, save_figure
from slam.scenario.schema import Scenario
from slam.scenario.shipped import find_scenario, shipped_scenarios


def summary(calibration: Calibration) -> TerminalTable:
    """Describe the factors, the resulting wheels, and UMBmark's figure before and after."""
    fit, errors = calibration.fit, calibration.errors
    factors = (
        ("left wheel, true per reported distance", fit.left, errors.left),
        ("right wheel, the same", fit.right, errors.right),
        ("track, true per assumed", fit.track, errors.track),
    )
    rows = [(name, f"{value:.5f} +- {2.0 * error:.5f}") for name, value, error in factors]
    rows.append(("right wheel to left wheel", f"{fit.right / fit.left:.5f}"))
    for name, wheels in (("before", WheelFit()), ("after", fit)):
        error = 100.0 * calibration.worst_closing_error(wheels)
        rows.append((f"misses the end of a square, {name}", f"{error:.2f} cm"))
    return TerminalTable(("", ""), rows)


def draw_squares(path: Path, calibration: Calibration) -> None:
    """Write the picture, whose suffix is its format; metres, each square in the frame of its start."""
    figure = Figure(figsize=(10, 5.4), dpi=110, layout="constrained")
    before, after = figure.subplots(1, 2, sharex=True, sharey=True)
    _draw(before, calibration, WheelFit(), "before")
    _draw(after, calibration, calibration.fit, "after")
    handles, labels = after.get_legend_handles_labels()
    unique = dict(zip(labels, handles, strict=True))
    figure.legend(unique.values(), unique.keys(), loc="outside lower center", ncols=3)
    with atomic_file(path) as draft:
        save_figure(figure, draft, format=path.suffix[1:])


def _draw(axes: Axes, calibration: Calibration, fit: WheelFit, title: str) -> None:
    error = 100.0 * calibration.worst_closing_error(fit)
    laps = calibration.laps
    for number, lap in enumerate(laps):
        colour, side = (PAPER.odometry, "right") if number < len(laps) / 2 else (PAPER.slam, "left")
        reckoned = from_start(corrected(lap.odometry, calibration.track, fit))
        axes.plot(*from_start(lap.truth).T, color="0.75", linewidth=3, label=calibration.against, zorder=1)
        axes.plot(*reckoned.T, color=colour, linewidth=1, label=f"odometry, to the {side}", zorder=2)
        axes.plot(*reckoned[-1], "o", color=colour, markersize=5, zorder=3)
    axes.set(title=f"{title}: misses the end by {error:.1f} cm", xlabel="x [m]", ylabel="y [m]", aspect="equal")
    axes.grid(color="0.93", linewidth=0.6)


def from_start(poses: FloatArray) -> FloatArray:
    """Return x and y (K, 2) of poses (K, 3) in the frame of the first."""
    return Pose2D(*poses[0]).inverse().transform(poses[:, :2])


def extends_value(name: str) -> str:
    """Return the value of ``extends`` for the file: a shipped scenario's name, or a path; ScenarioError for neither."""
    path = find_scenario(name)
    return name if name in shipped_scenarios() and not Path(name).is_file() else str(path.resolve())


def write_wheels(path: Path, extends: str, scenario: Scenario, backend: str, calibration: Calibration) -> None:
    """Write the file; InputError if that fails."""
    squares = f"{len(calibration.laps)} squares against {calibration.against}"
    content = {
        "extends": extends,
        "description": f"{scenario.name}, its wheels calibrated by {squares}",
    } | wheel_settings(scenario, backend, calibration.fit)
    errors = calibration.errors
    note = (
        f"# Two standard errors of the factors, from differences between squares: left wheel {2.0 * errors.left:.5f}, "
        f"right wheel {2.0 * errors.right:.5f}, track {2.0 * errors.track:.5f}.\n"
    )
    with require_writable(path, "choose another --out FILE"):
        write_atomic(path, note + yaml.safe_dump(content, sort_keys=False, allow_unicode=True))
