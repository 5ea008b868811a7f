"""Registry of the line extractors that are compared, by name, with the settings of each."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import islice
from time import perf_counter
from typing import Final

from slam.bench.probabilistic_hough import ProbabilisticHough
from slam.bench.ransac import Ransac
from slam.bench.scenes import NOISE_LEVELS, warm_up_scans
from slam.bench.split_and_merge import SplitAndMerge
from slam.config import ChiSquareConfig, HoppingConfig
from slam.lines.extraction import extract_segments
from slam.lines.learnt_noise import LearntNoise
from slam.lines.range_noise import RangeNoise, noise_of_sensor
from slam.lines.segments import Segments
from slam.scan import LaserScan


@dataclass(frozen=True, slots=True)
class LineExtractor:
    """Named function from a scan to line segments in the sensor frame."""

    name: str
    extract: Callable[[LaserScan], Segments]


OURS: Final = "ours"
SHORT: Final = 10
"""Scans from which noise is learnt: one second."""
LONG: Final = 50
"""Scans from which noise is learnt: a longer time."""


TUNED: Final = {
    "spec/19": (
        HoppingConfig(sigma_Th=0.025, L_Th=10),
        SplitAndMerge(max_distance=0.02, merge_distance=0.02, gap=0.02, gap_share=0.15),
        Ransac(max_distance=0.01, gap_share=0.1),
        ProbabilisticHough(cell=0.03, min_length=0.1),
    ),
    "spec/3": (HoppingConfig(sigma_Th=0.1, L_Th=20), SplitAndMerge(), Ransac(), ProbabilisticHough()),
    "spec": (
        HoppingConfig(sigma_Th=0.3, L_Th=20),
        SplitAndMerge(max_distance=0.3, merge_distance=0.2, gap=0.08, gap_share=0.1, min_points=16),
        Ransac(max_distance=0.06, gap_share=0.1, min_points=8),
        ProbabilisticHough(cell=0.1, min_length=0.5),
    ),
}
"""Best settings found on TUNING_SEEDS, by coordinate search for F1, at each level of noise."""


def compared_extractors(ours: LineExtractor, noise_level: str = "spec/3") -> tuple[LineExtractor, ...]:
    """Return the compared extractors: the paper's, this project's, and three others.

    The paper's runs twice, with its printed settings and with tuned ones. Split-and-merge, scikit-image's RANSAC and
    OpenCV's HoughLinesP are tuned.
    """
    hopping, split_and_merge, ransac, hough = TUNED[noise_level]
    return (
        LineExtractor("paper, printed", partial(extract_segments, config=HoppingConfig(L_Th=8))),
        LineExtractor("paper, tuned", partial(extract_segments, config=hopping)),
        ours,
        LineExtractor("split-and-merge", split_and_merge),
        LineExtractor("RANSAC", ransac),
        LineExtractor("Hough", hough),
    )


def ours_learning(config: ChiSquareConfig) -> LineExtractor:
    """This project's extractor as it runs: the noise is learnt from scan to scan."""
    noise = LearntNoise.start(config)
    return LineExtractor(OURS, lambda scan: extract_segments(scan, config, noise.observe(scan)))


def ours_of_noise(share: float, name: str = OURS) -> LineExtractor:
    """This project's extractor for range noise of this share of the maker's bound for the URG-04LX."""
    return _ours_with(name, noise_of_sensor("urg04lx", 1.0 / share))


def ours_by_knowledge(noise_level: str) -> tuple[LineExtractor, ...]:
    """Return this project's extractor with noise that is unknown, too small, too large, or learnt."""
    share = NOISE_LEVELS[noise_level]
    unnamed = ChiSquareConfig()
    named = ChiSquareConfig(sensor="urg04lx", bound_sigmas=3.0 / share)
    return (
        LineExtractor("ours, no sensor, one scan", partial(extract_segments, config=unnamed)),
        _ours_with(f"ours, no sensor, {LONG} scans", _learnt(unnamed, noise_level, LONG)),
        _ours_with(f"ours, noise x 1/3 at first, {SHORT} scans", _learnt(named, noise_level, SHORT)),
        ours_of_noise(share / 3.0, "ours, noise x 1/3"),
        ours_of_noise(2.0 * share, "ours, noise x 2"),
    )


def _ours_with(name: str, noise: RangeNoise) -> LineExtractor:
    return LineExtractor(name, partial(extract_segments, config=ChiSquareConfig(), noise=noise))


def _learnt(config: ChiSquareConfig, noise_level: str, scans: int) -> RangeNoise:
    """Return the noise learnt from this number of scans, in rooms that are not scored."""
    noise = LearntNoise.start(config)
    for scan in islice(warm_up_scans(noise_level), scans):
        noise.observe(scan)
    return noise.noise


def extract_in_turn(
    extractors: Sequence[LineExtractor], scans: Sequence[LaserScan], advance: Callable[[], object]
) -> Iterator[tuple[int, int, Segments, float]]:
    """Run the extractors in turn on each scan; yield the indices of both, the segments, and the seconds taken.

    ``advance`` is called after every scan.
    """
    for extractor in extractors:
        extractor.extract(scans[0])  # compiles
    for k, scan in enumerate(scans):
        for m, extractor in enumerate(extractors):
            began = perf_counter()
            segments = extractor.extract(scan)
            yield m, k, segments, perf_counter() - began
        advance()
