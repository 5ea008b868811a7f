"""RANSAC, one line after the other, with scikit-image (Fischler and Bolles 1981)."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from slam.bench.split_and_merge import fitted_line, segments_of
from slam.lines.segments import IntArray, Segments
from slam.named_code import import_optional
from slam.pose import FloatArray
from slam.scan import LaserScan


@dataclass(frozen=True, slots=True)
class Ransac:
    """Settings, lengths in metres; the defaults are tuned at the noise level ``spec/3`` of ``slam.bench.scenes``."""

    max_distance: float = 0.03
    """Largest distance of an inlier from its line, metres."""
    trials: int = 60
    gap: float = 0.12
    """Neighbouring points farther apart than this, plus ``gap_share`` of their range, are on different walls."""
    gap_share: float = 0.06
    max_hole: int = 5
    """Points in a row that may be off a line without ending its segment."""
    min_points: int = 6
    min_length: float = 0.15

    def __call__(self, scan: LaserScan) -> Segments:
        """Extract the segments of a scan, sensor frame."""
        measure = import_optional("skimage.measure", "bench")
        points = scan.points()
        ranges = np.hypot(*points.T)
        steps = np.hypot(*np.diff(points, axis=0).T)
        cuts = np.flatnonzero(steps > self.gap + self.gap_share * np.minimum(ranges[1:], ranges[:-1])) + 1
        random = np.random.default_rng(0)
        runs = [
            run
            for begin, stop in zip([0, *cuts], [*cuts, len(points)], strict=True)
            for run in self._runs(measure, points, int(begin), int(stop), random)
        ]
        lines = np.array([fitted_line(points, *run) for run in runs]).reshape(-1, 2)
        return segments_of(points, np.array(runs, dtype=np.int64).reshape(-1, 2), lines)

    def _runs(
        self, measure: Any, points: FloatArray, begin: int, stop: int, random: np.random.Generator
    ) -> Iterator[tuple[int, int]]:
        """Yield the longest run on the best line, and recursively those on either side of it."""
        if stop - begin < self.min_points:
            return
        _, inliers = measure.ransac(
            points[begin:stop], measure.LineModelND, 2, self.max_distance, max_trials=self.trials, rng=random
        )
        if inliers is None:
            return
        first, last = _longest(begin + np.flatnonzero(inliers), self.max_hole)
        if last - first + 1 < self.min_points or np.hypot(*(points[last] - points[first])) < self.min_length:
            return
        yield from self._runs(measure, points, begin, first, random)
        yield first, last
        yield from self._runs(measure, points, last + 1, stop, random)


def _longest(indices: IntArray, max_hole: int) -> tuple[int, int]:
    """Return first and last of the longest run of indices; ``max_hole`` missing indices in a row do not end a run."""
    parts = np.split(indices, np.flatnonzero(np.diff(indices) > max_hole + 1) + 1)
    longest = max(parts, key=len)
    return int(longest[0]), int(longest[-1])
