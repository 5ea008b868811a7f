"""The segments of scans as CSV and GeoJSON; metres and radians, sensor frame."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final

from slam.lines.segments import Segments

CSV_COLUMNS: Final = (
    "scan", "start_x", "start_y", "end_x", "end_y", "beams", "rho", "theta", "var_rho", "var_theta", "cov_rho_theta",
)  # fmt: skip
CSV_HEADER: Final = ",".join(CSV_COLUMNS) + "\n"


def csv_lines(scan: int, segments: Segments) -> str:
    """One line a segment, with its end; the covariance is empty where the method gives none."""
    rows = ([scan, *start, *end, *rest] for start, end, *rest in _values(segments))
    return "".join(",".join(_text(value) for value in row) + "\n" for row in rows)


def geojson_features(scan: int, segments: Segments) -> Iterator[dict[str, Any]]:
    """One LineString a segment, from its start to its end, with the other columns of the CSV as properties."""
    for start, end, *rest in _values(segments):
        yield {
            "type": "Feature",
            "geometry": {"type": "LineString", "coordinates": [start, end]},
            "properties": dict(zip(("scan", *CSV_COLUMNS[5:]), (scan, *rest), strict=True)),
        }


def _values(segments: Segments) -> Iterator[tuple[Any, ...]]:
    """start (x, y), end (x, y), beams, rho, theta, var_rho, var_theta, cov_rho_theta of each segment."""
    unknown = [None] * len(segments)
    variances = [unknown, unknown, unknown]
    if segments.covariance is not None:
        rho_rho, rho_theta, theta_theta = segments.covariance[:, [0, 0, 1], [0, 1, 1]].T.tolist()
        variances = [rho_rho, theta_theta, rho_theta]
    columns = (segments.start, segments.end, segments.counts, segments.rho, segments.theta)
    return zip(*(column.tolist() for column in columns), *variances, strict=True)


def _text(value: float | None) -> str:
    return "" if value is None else f"{value:.9g}"
