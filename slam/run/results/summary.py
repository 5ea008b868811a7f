"""The summary table of a run."""

from __future__ import annotations

from typing import Any

from rich.table import Table

_ERRORS = (
    ("ATE (rmse)", "ate_rmse_m", "m"),
    ("ATE (max)", "ate_max_m", "m"),
    ("final position", "final_m", "m"),
    ("|x| at most", "x_max_abs_m", "m"),
    ("|y| at most", "y_max_abs_m", "m"),
    ("heading (rmse)", "heading_rmse_deg", "deg"),
    ("|heading| at most", "heading_max_abs_deg", "deg"),
)
_FACTS = (
    ("scans (mapped)", "{scans} ({updates})"),
    ("path, time", "{path_m:.1f} m, {duration_s:.1f} s ({real_time_factor:.1f} x real time)"),
    ("iterations", "mean {iterations_mean:.0f}, max {iterations_max}; {not_converged} of {updates} did not settle"),
    ("SLAM a mapped scan", "median {slam_ms_median:.2f} ms, p99 {slam_ms_p99:.2f} ms"),
    ("map", "{map_points} points, {segments} segments"),
)


def summary_table(metrics: dict[str, Any]) -> Table:
    """A table of ``metrics.json``: the errors, where the truth is known, beside dead reckoning's, then the rest."""
    table = Table(box=None, pad_edge=False)
    known = "ate_rmse_m" in metrics
    for title in ("", "SLAM", "dead reckoning") if known else ("", ""):
        table.add_column(title, justify="left" if not title else "right")
    if known:
        for label, key, unit in _ERRORS:
            table.add_row(f"{label} [{unit}]", f"{metrics[key]:.3f}", f"{metrics['odometry_' + key]:.3f}", style="bold")
    if metrics["scans"]:
        for label, text in _FACTS:
            table.add_row(label, text.format(**metrics))
    return table
