"""Runs an experiment for a command: with viewers, a summary and an exit code."""

from collections.abc import Callable, Iterator
from typing import Any, Final

import typer

from slam.console.terminal import Terminal
from slam.console.terminal_table import TerminalTable
from slam.run.results.metric_table import METRICS, Metric
from slam.run.run import Run
from slam.run.viewer.viewers import Viewers

_ERRORS: Final = (
    "ate_rmse_m", "ate_max_m", "final_m", "x_max_abs_m", "y_max_abs_m", "heading_rmse_deg", "heading_max_abs_deg",
)  # fmt: skip
_COLUMNS: Final = {"SLAM": "", "closed": "closed_", "dead reckoning": "odometry_"}
"""Trajectories, and the prefixes of their keys in ``metrics.json``."""
_LOOPS: Final = "{loops_believed} of {loops} believed; {closures} closures during the run, {closing_s:.1f} s at the end"
_WALL_SHARES: Final = ("wall_precision", "wall_recall")
_WALL_ERRORS: Final = ("wall_length_error_m", "wall_end_error_m", "wall_end_error_p90_m")
_WALL_FAULTS: Final = ("wall_free_air_m", "wall_phantom_m", "wall_doubled_m")
_AFTER: Final = ("sure_after_s", "right_after_s")
_FACTS: Final = (
    ("scans (mapped)", "{scans} ({updates})"),
    (
        "odometry alone",
        "{odometry_only} of {updates} matched scans ({odometry_only_share:.1%}) were rejected",
    ),
    ("path, time", "{path_m:.1f} m, {duration_s:.1f} s{speed}"),
    ("iterations", "mean {iterations_mean:.0f}, max {iterations_max}; {not_converged} of {updates} did not converge"),
    ("SLAM a mapped scan", "median {slam_ms_median:.2f} ms, p99 {slam_ms_p99:.2f} ms"),
    ("map", "{map_points} points or surfels; {segments} segments seen"),
)


def run_and_report(
    make: Callable[[Viewers], Run], rerun: list[str] | None, console: Terminal, lenient: bool = False
) -> None:
    """Run the experiment, print its summary, and keep the web viewer open until Ctrl-C, if there is one.

    Raises the error of a run that failed, and ScansLost if most of its log could not be used, unless ``lenient``. Exits
    with code 130 after Ctrl-C, 128 + N after the signal N.
    """
    with Viewers(rerun or (), console) as viewers:
        run = make(viewers)
        console.print(*summary_tables(run.metrics))
        console.warn(*run.warnings)
        console.print(f"{run.ending}; results in {run.folder}")
        if run.error is not None:
            raise run.error
        if run.ending == "interrupted":
            raise typer.Exit(128 + run.signal)
        viewers.serve_until_interrupted()
        if run.loss is not None:
            run.loss.require_most(lenient)


def summary_tables(metrics: dict[str, Any]) -> Iterator[TerminalTable]:
    """Make tables of ``metrics.json``: errors if the true pose is known, then the rest.

    The errors are those of SLAM during the run, of the run with its loops closed, and of dead reckoning.
    """
    if "ate_rmse_m" in metrics:
        columns = {name: prefix for name, prefix in _COLUMNS.items() if f"{prefix}ate_rmse_m" in metrics}
        errors = [
            (_label(METRICS[key]), *(f"{metrics[prefix + key]:.3f}" for prefix in columns.values())) for key in _ERRORS
        ]
        yield TerminalTable(("", *columns), errors, bold_rows=len(errors))
    found = list(_localization(metrics)) if "lost_scans" in metrics else []
    speed = (
        f" ({metrics['real_time_factor']:.1f} x real time)" if "real_time_factor" in metrics else ""
    )  # not for a killed run
    facts = [(label, text.format(**metrics, speed=speed)) for label, text in _FACTS] if metrics["scans"] else []
    if metrics.get("loops"):
        facts.append(("loops", _LOOPS.format(**metrics)))
    if "range_noise_m" in metrics:
        facts.append(("range noise", _range_noise(metrics)))
    facts += list(_base(metrics))
    if "wall_mapped_m" in metrics:
        facts += list(_walls(metrics))
    if found or facts:
        yield TerminalTable(("", ""), [*found, *facts], bold_rows=len(found))


def _label(metric: Metric) -> str:
    """Format quantity, statistic and unit, as in ``ATE (rmse) [m]``."""
    statistic = f" ({metric.statistic})" if metric.statistic else ""
    return f"{metric.quantity}{statistic} [{metric.unit}]"


def _range_noise(metrics: dict[str, Any]) -> str:
    """Format the noise, as in ``8 mm, 0.8 % beyond 1.0 m; as named: 3 mm``."""
    near, far = metrics["range_noise_m"], metrics["range_noise_share"]
    named = f"; as named: {1e3 * metrics['named_range_noise_m']:.0f} mm" if "named_range_noise_m" in metrics else ""
    return f"{1e3 * near:.0f} mm, {100 * far:.1f} % beyond {near / far:.1f} m{named}"


def _base(metrics: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Make rows on the state that the base reported, if it did."""
    if "battery_end_v" in metrics:
        yield "battery", "{battery_start_v:.1f} V at the start, {battery_end_v:.1f} V at the end".format(**metrics)
    if metrics.get("stalled_scans"):
        yield "stalled", "{stalled_scans} of {scans} scans: a wheel could not turn".format(**metrics)
    if metrics.get("fault_scans"):
        yield "faults", "{fault_scans} of {scans} scans: fault_flags in steps.csv says which".format(**metrics)
    if "sonar_nearest_m" in metrics:
        yield "sonar", "nearest echo {sonar_nearest_m:.2f} m".format(**metrics)


def _walls(metrics: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Make rows on the line map against the true walls."""
    known = {key: METRICS[key].shown(metrics[key]) for key in metrics if key.startswith("wall_")}
    share = {key: "none" if metrics[key] is None else f"{100 * metrics[key]:.1f} %" for key in _WALL_SHARES}
    precision, recall = share.values()
    yield (
        "line map",
        "{} of its {} m lie on walls; {} of the {} m of wall that were seen are in it".format(
            precision, known["wall_mapped_m"], recall, known["wall_seen_m"]
        ),
    )
    yield "wall errors", "length {} m; ends {} m (median), {} m (90 %)".format(*(known[key] for key in _WALL_ERRORS))
    faults = (known[key] for key in _WALL_FAULTS)
    yield "false walls", "{} m in free air, the longest {} m; {} m shown twice".format(*faults)


def _localization(metrics: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Make rows that only a run in a saved map has."""
    after = {key: "never" if metrics.get(key) is None else f"{metrics[key]:.1f} s" for key in _AFTER}
    sure, right = (METRICS[key].name for key in _AFTER)
    yield sure, f"{after['sure_after_s']}, lost in {metrics['lost_scans']} scans"
    if "right_after_s" in metrics:
        yield right, f"{after['right_after_s']}, sure but wrong in {metrics['wrong_scans']} scans"
    if "tracking_rmse_m" in metrics:
        rest = f"max {metrics['tracking_max_m']:.3f} m, {metrics['tracking_rmse_deg']:.2f} deg"
        yield "tracking", f"{metrics['tracking_rmse_m']:.3f} m rmse, {rest}"
