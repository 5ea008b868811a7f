"""The line extractors that are compared, by name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Final

from slam.bench.hough_peer import ProbabilisticHough
from slam.bench.ransac_peer import Ransac
from slam.bench.split_and_merge import SplitAndMerge
from slam.config import ChiSquareConfig, HoppingConfig
from slam.lines.extraction import extract_segments
from slam.lines.segments import Segments
from slam.scan import LaserScan


@dataclass(frozen=True, slots=True)
class Method:
    """A line extractor: segments in the sensor frame from a scan."""

    name: str
    extract: Callable[[LaserScan], Segments]


OURS: Final = "ours"


def _slam(name: str, config: HoppingConfig | ChiSquareConfig) -> Method:
    return Method(name, partial(extract_segments, config=config))


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


def all_methods(noise_level: str = "spec/3", ours: ChiSquareConfig | None = None) -> tuple[Method, ...]:
    """The paper's as printed, and tuned; this project's; and three of the field, tuned: split-and-merge, scikit-image's
    RANSAC, OpenCV's HoughLinesP. Without settings ours knows no sensor, and estimates the noise from every scan.
    """
    hopping, split_and_merge, ransac, hough = TUNED[noise_level]
    return (
        _slam("paper, printed", HoppingConfig(L_Th=8)),
        _slam("paper, tuned", hopping),
        _slam(OURS, ours or ChiSquareConfig()),
        Method("split-and-merge", split_and_merge),
        Method("RANSAC", ransac),
        Method("Hough", hough),
    )


def told_the_noise(noise: float) -> ChiSquareConfig:
    """Settings of ours that know the sensor: its noise is this share of the bound that the URG-04LX's maker gives."""
    return ChiSquareConfig(sensor="urg04lx", bound_sigmas=1.0 / noise)


def ours_misled(noise: float) -> tuple[Method, ...]:
    """Ours without a sensor, and told of too little and of too much noise."""
    return (
        _slam("ours, no sensor named", ChiSquareConfig()),
        _slam("ours, sigma x 0.7", told_the_noise(0.7 * noise)),
        _slam("ours, sigma x 2", told_the_noise(2.0 * noise)),
    )
