"""Score of line extractors on a recorded log without ground truth: the share of beams that segments explain."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from slam.bench.line_extractors import OURS, LineExtractor, extract_in_turn
from slam.bench.stopwatch import microseconds
from slam.console.result_table import ResultTable
from slam.files.logs import Log
from slam.pose import FloatArray

EXPLAINED_WITHIN: Final = 0.10
"""A beam is explained if it ends nearer than this, metres, to a segment."""
MAX_SCANS: Final = 200
COLUMNS: Final = ("method", "explained\n%", "rmse\nmm", "segments\na scan", "time\nus", "p99\nus", "x\nours")


@dataclass(frozen=True, slots=True, eq=False)
class LogScore:
    """Result of one extractor on a log."""

    method: str
    explained: float
    """Share of the beams with an echo."""
    rmse: float
    """Distance of the explained beams from their segments, metres."""
    segments: float
    """Segments per scan, on average."""
    times: FloatArray
    """Seconds per scan."""


def sampled_scans(log: Log) -> list[int]:
    """Return the indices of the scans to use: all, or MAX_SCANS evenly spaced ones."""
    return [round(place) for place in np.linspace(0, len(log) - 1, min(len(log), MAX_SCANS)).tolist()]


def score_log(log: Log, extractors: Sequence[LineExtractor], advance: Callable[[], object]) -> list[LogScore]:
    """Run the extractors on these scans of the log; ``advance`` is called after every scan."""
    scans = [log.scan(index) for index in sampled_scans(log)]
    found: list[list[tuple[FloatArray, int, float]]] = [[] for _ in extractors]
    for m, k, segments, taken in extract_in_turn(extractors, scans, advance):
        distances = distances_to_segments(scans[k].points(), segments.start, segments.end)
        found[m].append((distances, len(segments), taken))
    return [_log_score(extractor.name, rows) for extractor, rows in zip(extractors, found, strict=True)]


def distances_to_segments(points: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    """Return the metres from each point (N, 2) to the nearest of the segments (M, 2, 2), shape (N,).

    The distance is ``inf`` without any segment.
    """
    along = end - start
    squared = np.maximum(np.sum(along**2, axis=1), 1e-12)
    offset = points[:, None] - start
    share = np.clip(np.sum(offset * along, axis=2) / squared, 0.0, 1.0)
    return np.asarray(np.linalg.norm(offset - share[..., None] * along, axis=2).min(axis=1, initial=np.inf))


def log_table(name: str, log: Log, scores: list[LogScore]) -> ResultTable:
    """Make the table of a log."""
    ours = next(float(np.median(row.times)) for row in scores if row.method == OURS)
    rows = [
        (
            row.method, f"{100 * row.explained:.1f}", f"{1e3 * row.rmse:.1f}", f"{row.segments:.1f}",
            *microseconds(row.times, ours),
        )
        for row in scores
    ]  # fmt: skip
    title = f"{name}: {len(scores[0].times)} of {len(log)} scans, {log.lidar.beams} beams each"
    notes = "Explained: share of the beams that end within 10 cm of a segment; rmse: of those. Time: median."
    return ResultTable(title, COLUMNS, rows, notes)


def _log_score(name: str, rows: list[tuple[FloatArray, int, float]]) -> LogScore:
    distances, segments, times = zip(*rows, strict=True)
    distance = np.concatenate(distances)
    near = distance[distance < EXPLAINED_WITHIN]
    rmse = float(np.sqrt(np.mean(near**2))) if len(near) else np.nan
    return LogScore(name, len(near) / max(len(distance), 1), rmse, float(np.mean(segments)), np.array(times))
