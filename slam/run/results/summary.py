"""The summary of a run: tables for the terminal."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from slam.console.terminal_table import TerminalTable

_ERRORS = (
    ("ATE (rmse)", "ate_rmse_m", "m"),
    ("ATE (max)", "ate_max_m", "m"),
    ("final position", "final_m", "m"),
    ("|x| at most", "x_max_abs_m", "m"),
    ("|y| at most", "y_max_abs_m", "m"),
    ("heading (rmse)", "heading_rmse_deg", "deg"),
    ("|heading| at most", "heading_max_abs_deg", "deg"),
)
_AFTER = ("sure_after_s", "right_after_s")
_FACTS = (
    ("scans (mapped)", "{scans} ({updates})"),
    ("path, time", "{path_m:.1f} m, {duration_s:.1f} s ({real_time_factor:.1f} x real time)"),
    ("iterations", "mean {iterations_mean:.0f}, max {iterations_max}; {not_converged} of {updates} did not settle"),
    ("SLAM a mapped scan", "median {slam_ms_median:.2f} ms, p99 {slam_ms_p99:.2f} ms"),
    ("map", "{map_points} points or surfels; {segments} segments seen"),
)


def summary_tables(metrics: dict[str, Any]) -> Iterator[TerminalTable]:
    """Tables of ``metrics.json``: the errors of SLAM beside those of dead reckoning, where the truth is known; then
    the rest."""
    if "ate_rmse_m" in metrics:
        errors = [
            (f"{label} [{unit}]", f"{metrics[key]:.3f}", f"{metrics['odometry_' + key]:.3f}")
            for label, key, unit in _ERRORS
        ]
        yield TerminalTable(("", "SLAM", "dead reckoning"), errors, bold_rows=len(errors))
    found = list(_localization(metrics)) if "lost_scans" in metrics else []
    facts = [(label, text.format(**metrics)) for label, text in _FACTS] if metrics["scans"] else []
    if found or facts:
        yield TerminalTable(("", ""), [*found, *facts], bold_rows=len(found))


def _localization(metrics: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """What a run in a saved map has beside the others."""
    after = {key: "never" if metrics.get(key) is None else f"{metrics[key]:.1f} s" for key in _AFTER}
    yield "sure after", f"{after['sure_after_s']}, lost in {metrics['lost_scans']} scans"
    if "right_after_s" in metrics:
        yield "right after", f"{after['right_after_s']}, sure but wrong in {metrics['wrong_scans']} scans"
    if "tracking_rmse_m" in metrics:
        rest = f"max {metrics['tracking_max_m']:.3f} m, {metrics['tracking_rmse_deg']:.2f} deg"
        yield "tracking", f"{metrics['tracking_rmse_m']:.3f} m rmse, {rest}"
