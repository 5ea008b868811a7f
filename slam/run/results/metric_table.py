"""Numbers of ``metrics.json``: name, unit, meaning and format of each."""

from dataclasses import dataclass
from datetime import datetime
from typing import Any, Final


@dataclass(frozen=True, slots=True)
class Metric:
    """One number of a run."""

    key: str
    quantity: str
    statistic: str
    """Name of the statistic; empty for a quantity that is one number."""
    unit: str
    meaning: str
    form: str = ".3f"
    less_is_better: bool = False
    more_is_better: bool = False
    """If neither is set, no value is better than another."""

    @property
    def name(self) -> str:
        """Quantity and statistic, as in ``ATE, rmse``."""
        return f"{self.quantity}, {self.statistic}" if self.statistic else self.quantity

    def shown(self, value: Any) -> str:
        """Format the value for a table; a dash if it is unknown."""
        if value is None:
            return "–"  # noqa: RUF001  # a dash, as printed
        return format(int(value) if self.form == "d" else float(value), self.form)


_METRICS: Final = (
    Metric("ate_rmse_m", "ATE", "rmse", "m", "Root mean square of the position error over all scans.", ".4f", True),
    Metric("ate_max_m", "ATE", "max", "m", "Largest position error of any scan.", ".4f", True),
    Metric("final_m", "final position", "", "m", "Position error at the last scan.", ".4f", True),
    Metric("x_max_abs_m", "|x| at most", "", "m", "Largest error along the map's x axis.", ".4f", True),
    Metric("y_max_abs_m", "|y| at most", "", "m", "Largest error along the map's y axis.", ".4f", True),
    Metric("heading_rmse_deg", "heading", "rmse", "deg", "Root mean square of the heading error.", ".3f", True),
    Metric("heading_max_abs_deg", "|heading| at most", "", "deg", "Largest heading error of any scan.", ".3f", True),
    Metric(
        "sure_after_s",
        "sure after",
        "",
        "s",
        "Time until the robot was sure of its pose in the saved map.",
        ".1f",
        True,
    ),
    Metric("right_after_s", "right after", "", "s", "Time until the robot was sure of its true pose.", ".1f", True),
    Metric("lost_scans", "lost", "", "scans", "Scans in which the robot was not sure of its pose.", "d", True),
    Metric("odometry_only", "odometry alone", "", "scans", "Matched scans that were rejected.", "d", True),
    Metric(
        "odometry_only_share", "odometry alone", "share", "", "The same as a share of the matched scans.", ".3f", True
    ),
    Metric(
        "wrong_scans", "sure but wrong", "", "scans", "Scans in which the robot was sure of a wrong pose.", "d", True
    ),
    Metric(
        "wall_precision",
        "walls",
        "precision",
        "",
        "Share of the mapped length that is true wall.",
        ".3f",
        False,
        True,
    ),
    Metric(
        "wall_recall", "walls", "recall", "", "Share of the walls seen three times that is mapped.", ".3f", False, True
    ),
    Metric(
        "wall_free_air_m", "walls", "in free air", "m", "Mapped length more than 0.1 m from any solid.", ".2f", True
    ),
    Metric("wall_phantom_m", "walls", "longest phantom", "m", "Longest piece of one line in free air.", ".2f", True),
    Metric(
        "wall_doubled_m",
        "walls",
        "doubled",
        "m",
        "Length of lines on a part of a wall that another line already shows.",
        ".2f",
        True,
    ),
    Metric("wall_length_error_m", "wall lengths", "median", "m", "Error of the length of a whole wall.", ".3f", True),
    Metric(
        "wall_end_error_m", "wall ends", "median", "m", "Distance of a wall's end from the mapped end.", ".3f", True
    ),
    Metric("wall_end_error_p90_m", "wall ends", "90 %", "m", "The same for nine of ten ends.", ".3f", True),
    Metric("wall_mapped_m", "walls", "mapped", "m", "Length of all lines of the map.", ".1f"),
    Metric("wall_seen_m", "walls", "seen", "m", "Length of the true walls that were seen three times.", ".1f"),
    Metric("loops", "loops", "found", "", "Submaps that were found again in an earlier one.", "d"),
    Metric("loops_believed", "loops", "believed", "", "Loops that the graph accepts.", "d"),
    Metric("closures", "loops", "during the run", "", "Scans at which pose and map were corrected by loops.", "d"),
    Metric("closing_s", "loops", "at the end", "s", "Wall time of the final loop closing.", ".1f", True),
    Metric("scans", "scans", "", "", "Scans that the robot took.", "d"),
    Metric("updates", "mapped", "", "scans", "Scans that were matched and mapped.", "d"),
    Metric("path_m", "path", "", "m", "Length of the path, of the true one if it is known.", ".1f"),
    Metric("duration_s", "duration", "", "s", "Time from the first scan to the last, by their stamps.", ".1f"),
    Metric("iterations_mean", "iterations", "mean", "", "Iterations of the matcher until it converged.", ".1f", True),
    Metric("iterations_max", "iterations", "max", "", "Largest number for one scan.", "d", True),
    Metric("not_converged", "not converged", "", "scans", "Matches that reached the limit of iterations.", "d", True),
    Metric("slam_ms_median", "SLAM", "median", "ms", "Processing time of a mapped scan, median.", ".2f", True),
    Metric("slam_ms_p99", "SLAM", "99 %", "ms", "The same, 99th percentile.", ".2f", True),
    Metric("extraction_ms_median", "extraction", "median", "ms", "The part of it for extracting lines.", ".2f", True),
    Metric("real_time_factor", "speed", "", "x", "Speed relative to real time, including the simulator.", ".1f"),
    Metric(
        "range_noise_m", "range noise", "near", "m", "Standard deviation of near ranges, learnt from the scans.", ".4f"
    ),
    Metric("range_noise_share", "range noise", "far", "", "The same for far ranges, relative to the range.", ".4f"),
    Metric("named_range_noise_m", "range noise", "as named", "m", "Noise of near ranges of the named sensor.", ".4f"),
    Metric("map_points", "map", "", "points", "Points or surfels in the map at the end.", "d"),
    Metric("stalled_scans", "stalled", "", "scans", "Scans at which a wheel could not turn.", "d", True),
    Metric("fault_scans", "faults", "", "scans", "Scans at which the base reported a fault.", "d", True),
    Metric("battery_start_v", "battery", "start", "V", "Voltage at the first scan.", ".1f"),
    Metric("battery_end_v", "battery", "end", "V", "Voltage at the last scan.", ".1f"),
    Metric("sonar_nearest_m", "sonar", "nearest", "m", "Nearest echo of the sonar rings.", ".2f"),
    Metric("segments", "segments", "", "", "Line segments of all mapped scans.", "d"),
)

_TEXTS: Final = frozenset(
    {"began", "ending", "error", "version", "log", "log_report", "map", "start", "backend", "back_end_lost"}
)
_LARGEST: Final = 1e18
METRICS: Final = {metric.key: metric for metric in _METRICS}
"""Every metric by its key, in the order of the tables."""


def more_is_better(key: str) -> bool:
    """Return True for a metric whose greatest value is the best; False for all other keys."""
    return key in METRICS and METRICS[key].more_is_better


def metrics_fault(metrics: Any) -> str | None:
    """Describe the fault in the content of a ``metrics.json``; None if there is none."""
    if not isinstance(metrics, dict):
        return f"is not an object but {str(metrics)[:20]!r}"
    for key, value in metrics.items():
        number = key.removeprefix("closed_").removeprefix("odometry_") in METRICS
        if number and not (value is None or (isinstance(value, int | float) and abs(value) < _LARGEST)):
            return f"{key}: {str(value)[:20]!r} is not a number"
        if key in _TEXTS and not isinstance(value, str):
            return f"{key}: {str(value)[:20]!r} is not text"
    return None if _is_date(metrics.get("began")) else f"began: {metrics['began']!r} is not a date"


def _is_date(text: str | None) -> bool:
    try:
        return text is None or bool(datetime.fromisoformat(text))
    except ValueError:
        return False
