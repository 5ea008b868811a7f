"""The segments of the scans of a recorded log, written to files or shown."""

import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from slam.config import ChiSquareConfig, HoppingConfig
from slam.errors import InputError
from slam.files.atomic_files import GrowingGeoJson, GrowingText, line_feature, require_writable
from slam.files.logs import Log
from slam.lidars import LIDARS
from slam.lines.extraction import extract_segments
from slam.lines.learnt_noise import LearntNoise
from slam.lines.segments import Segments
from slam.run.pictures.scan_picture import draw_scan
from slam.run.pictures.world_picture import check_picture

CSV_COLUMNS: Final = (
    "scan", "start_x", "start_y", "end_x", "end_y", "beams", "rho", "theta", "var_rho", "var_theta", "cov_rho_theta",
)  # fmt: skip
CSV_HEADER: Final = ",".join(CSV_COLUMNS) + "\n"
METHODS: Final = ("paper", "chi_square")


def csv_lines(scan: int, segments: Segments) -> str:
    """Format one line per segment, with its end; the covariance is empty if the method gives none."""
    rows = ([scan, *start, *end, *rest] for start, end, *rest in _values(segments))
    texts = (["" if value is None else f"{value:.9g}" for value in row] for row in rows)
    return "".join(",".join(row) + "\n" for row in texts)


def geojson_features(scan: int, segments: Segments) -> Iterator[dict[str, Any]]:
    """Make one LineString per segment, from its start to its end, with the other columns of the CSV as properties."""
    for start, end, *rest in _values(segments):
        yield line_feature([start, end], dict(zip(("scan", *CSV_COLUMNS[5:]), (scan, *rest), strict=True)))


def _values(segments: Segments) -> Iterator[tuple[Any, ...]]:
    """Yield start (x, y), end (x, y), beams, rho, theta, var_rho, var_theta, cov_rho_theta of each segment."""
    unknown = [None] * len(segments)
    variances = [unknown, unknown, unknown]
    if segments.covariance is not None:
        rho_rho, rho_theta, theta_theta = segments.covariance[:, [0, 0, 1], [0, 1, 1]].T.tolist()
        variances = [rho_rho, theta_theta, rho_theta]
    columns = (segments.start, segments.end, segments.counts, segments.rho, segments.theta)
    return zip(*(column.tolist() for column in columns), *variances, strict=True)


@dataclass(frozen=True, slots=True)
class Outputs:
    """Files for the segments; without one, CSV is written to standard output."""

    csv: Path | None = None
    geojson: Path | None = None
    png: Path | None = None


def line_config(method: str, sensor: str | None) -> HoppingConfig | ChiSquareConfig:
    """Return the settings of a method by name, with the noise of the named sensor; InputError lists the known ones."""
    if method not in METHODS:
        raise InputError(f"no method named {method!r}; choose one of {', '.join(METHODS)}")
    if method == "chi_square":
        return chi_square_config(sensor)
    if sensor is not None:
        raise InputError("--sensor says what noise to expect, and method paper asks for none; leave one of them out")
    return HoppingConfig()


def chi_square_config(sensor: str | None) -> ChiSquareConfig:
    """Return the settings of this project's method for the named sensor; InputError lists the known ones."""
    if sensor is not None and sensor not in LIDARS:
        raise InputError(f"no sensor named {sensor!r}; choose one of {', '.join(LIDARS)}, or leave --sensor out")
    return ChiSquareConfig.model_validate({"sensor": sensor})


def chosen_scans(log: Log, scan: int | None) -> range:
    """Return scan ``k``, or all; InputError if the log has no such scan."""
    if scan is None:
        return range(len(log))
    if not 0 <= scan < len(log):
        raise InputError(f"no scan {scan} in this log; choose one from 0 to {len(log) - 1}")
    return range(scan, scan + 1)


def write_lines(
    log: Log, scans: range, config: HoppingConfig | ChiSquareConfig, outputs: Outputs,
    track: Callable[[Iterable[int]], Iterable[int]] = iter,
) -> int:  # fmt: skip
    """Extract the segments of these scans and write them; return their number. ``track`` shows the progress."""
    if outputs.png is not None and len(scans) != 1:
        raise InputError(f"{outputs.png}: a picture shows one scan; give --scan K")
    if outputs.png is not None:
        check_picture(outputs.png, "--png")
    count, noise = 0, LearntNoise.start(config)
    with require_writable(None, "choose another file"), ExitStack() as stack:
        sinks = list(_sinks(log, outputs, stack))
        for index in track(scans):
            scan = log.scan(index)
            segments = extract_segments(scan, config, noise.observe(scan))
            count += len(segments)
            for sink in sinks:
                sink(index, segments)
    return count


def _sinks(log: Log, outputs: Outputs, stack: ExitStack) -> Iterator[Callable[[int, Segments], object]]:
    """Yield the functions that write the segments of a scan, given its number."""
    if outputs == Outputs():
        sys.stdout.write(CSV_HEADER)
        yield lambda scan, segments: sys.stdout.write(csv_lines(scan, segments))
    if (path := outputs.csv) is not None:
        text = stack.enter_context(GrowingText(path, CSV_HEADER))
        yield lambda scan, segments: text.append(csv_lines(scan, segments))
    if (path := outputs.geojson) is not None:
        features = stack.enter_context(GrowingGeoJson(path, frame="sensor", unit="metre"))
        yield lambda scan, segments: features.append(geojson_features(scan, segments))
    if (png := outputs.png) is not None:
        yield lambda scan, segments: draw_scan(
            png, log.scan(scan).points(), segments, f"scan {scan}: {len(segments)} segments"
        )
