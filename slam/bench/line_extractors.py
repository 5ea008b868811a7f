"""Registry of the line extractors that are compared, by name, with the settings of each."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from time import perf_counter
from typing import Final

from slam.bench.probabilistic_hough import ProbabilisticHough
from slam.bench.ransac import Ransac
from slam.bench.split_and_merge import SplitAndMerge
from slam.config import ChiSquareConfig, HoppingConfig
from slam.lines.extraction import extract_segments
from slam.lines.segments import Segments
from slam.scan import LaserScan


@dataclass(frozen=True, slots=True)
class LineExtractor:
    """Named function from a scan to line segments in the sensor frame."""

    name: str
    extract: Callable[[LaserScan], Segments]


OURS: Final = "ours"


def _slam_extractor(name: str, config: HoppingConfig | ChiSquareConfig) -> LineExtractor:
    return LineExtractor(name, partial(extract_segments, config=config))


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
"""The best settings found on TUNING_SEEDS, by coordinate search for F1, at each level of noise."""


def compared_extractors(noise_level: str = "spec/3", ours: ChiSquareConfig | None = None) -> tuple[LineExtractor, ...]:
    """Extractors that are compared: the paper's, this project's, and three of the field.

    The paper's is as printed, and tuned; split-and-merge, scikit-image's RANSAC and OpenCV's HoughLinesP are tuned.
    Without settings ours knows no sensor, and estimates the noise from every scan.
    """
    hopping, split_and_merge, ransac, hough = TUNED[noise_level]
    return (
        _slam_extractor("paper, printed", HoppingConfig(L_Th=8)),
        _slam_extractor("paper, tuned", hopping),
        _slam_extractor(OURS, ours or ChiSquareConfig()),
        LineExtractor("split-and-merge", split_and_merge),
        LineExtractor("RANSAC", ransac),
        LineExtractor("Hough", hough),
    )


def config_of_noise(noise: float) -> ChiSquareConfig:
    """Settings of ours for range noise that is this share of the bound that the URG-04LX's maker gives."""
    return ChiSquareConfig(sensor="urg04lx", bound_sigmas=1.0 / noise)


def ours_with_wrong_noise(noise: float) -> tuple[LineExtractor, ...]:
    """This project's extractor without a sensor, and with too little and too much noise expected."""
    return (
        _slam_extractor("ours, no sensor named", ChiSquareConfig()),
        _slam_extractor("ours, sigma x 0.7", config_of_noise(0.7 * noise)),
        _slam_extractor("ours, sigma x 2", config_of_noise(2.0 * noise)),
    )


def extract_in_turn(
    extractors: Sequence[LineExtractor], scans: Sequence[LaserScan], advance: Callable[[], object]
) -> Iterator[tuple[int, int, Segments, float]]:
    """Run the extractors in turn on each scan; gives the indices of both, the segments, and the seconds taken.

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
