"""The squares before and after: where the odometry says that they end, and where they ended."""

from __future__ import annotations

from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from slam.files.figure_file import save_figure
from slam.files.palette import PAPER
from slam.files.whole_files import whole_file
from slam.pose import FloatArray, Pose2D
from slam.run.calibration.calibrate import Calibration
from slam.run.calibration.wheel_fit import WheelFit, corrected


def draw_squares(path: Path, calibration: Calibration) -> None:
    """Write the picture, whose suffix names its format; metres, each square in the frame of its start."""
    figure = Figure(figsize=(10, 5.4), dpi=110, layout="constrained")
    before, after = figure.subplots(1, 2, sharex=True, sharey=True)
    _draw(before, calibration, WheelFit(), "before")
    _draw(after, calibration, calibration.fit, "after")
    handles, labels = after.get_legend_handles_labels()
    unique = dict(zip(labels, handles, strict=True))
    figure.legend(unique.values(), unique.keys(), loc="outside lower center", ncols=3)
    with whole_file(path) as draft:
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
    """x and y (K, 2) of poses (K, 3) in the frame of the first."""
    return Pose2D.from_array(poses[0]).inverse().transform(poses[:, :2])
