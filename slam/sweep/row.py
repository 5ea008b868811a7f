"""A row of a sweep's results: what was run, where, and what came out. Plain values, as JSON has them."""

from __future__ import annotations

from typing import Any, Final, TypeAlias

from slam.run.experiment import Outcome
from slam.sweep.job import Job, setting

Row: TypeAlias = dict[str, Any]
"""``id``, ``name``, ``source``, ``kind``, ``mode``, ``seed``; ``set.<key>`` and ``drawn.<key>`` for settings;
``status`` (``done`` or ``failed``), ``ending``, ``error``, ``tries``; every number of ``metrics.json`` by its name,
those of WALL_TIMES after ``wall.``; ``error_m``: the error along the way, (STATIONS,); ``seconds``, ``host`` and
``version``; ``settings`` and ``command``, which repeat the run."""

WALL_TIMES: Final = frozenset(
    {"slam_ms_median", "slam_ms_p99", "slam_s_total", "extraction_ms_median", "real_time_factor"}
)
"""Metrics that are another time every time; all others are the same bits when a run is repeated."""
_TOLD: Final = frozenset({"seed", "version", "ending"})
"""What stands in a row anyway."""


def job_columns(job: Job) -> Row:
    """What a row says of its job."""
    row = job.model_dump(include={"id", "name", "source", "kind", "mode", "seed"})
    row |= {f"set.{key}": _plain(value) for key, value in job.grid.items()}
    row |= {f"drawn.{key}": _plain(value) for key, value in job.drawn.items()}
    return row | {"settings": list(job.settings), "command": job.command}


def done(job: Job, outcome: Outcome) -> Row:
    """The row of a run that came to an end; ``failed`` where the robot did."""
    numbers = {key: value for key, value in outcome.metrics.items() if isinstance(value, int | float)}
    metrics = {f"wall.{key}" if key in WALL_TIMES else key: numbers[key] for key in numbers if key not in _TOLD}
    error = None if outcome.error is None else str(outcome.error)
    status = "done" if error is None else "failed"
    return job_columns(job) | {"status": status, "ending": outcome.ending, "error": error} | metrics


def failed(job: Job, error: str) -> Row:
    """The row of a run that came to none."""
    return job_columns(job) | {"status": "failed", "ending": None, "error": error}


def comparable(row: Row) -> Row:
    """What must be the same when the run is repeated: all that came out, but for times, and what has no value."""
    apart = {"seconds", "host", "tries", "started", "version", "command"}
    return {
        key: value
        for key, value in row.items()
        if value is not None and key not in apart and not key.startswith(("wall.", "set.", "drawn."))
    }


def _plain(value: Any) -> Any:
    """A number or text."""
    return value if isinstance(value, int | float | str) else setting("", value)[1:]
