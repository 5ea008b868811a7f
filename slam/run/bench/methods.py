"""The line extractors that are compared, by name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Final

from slam.config import ChiSquareConfig, HoppingConfig
from slam.lines.extraction import extract_segments
from slam.lines.segments import Segments
from slam.run.bench.hough_peer import ProbabilisticHough
from slam.run.bench.ransac_peer import Ransac
from slam.run.bench.split_and_merge import SplitAndMerge
from slam.run.log_lines import chi_square_config
from slam.scan import LaserScan


@dataclass(frozen=True, slots=True)
class Method:
    """A line extractor: segments in the sensor frame from a scan."""

    name: str
    extract: Callable[[LaserScan], Segments]


OURS: Final = "ours"


def _slam(name: str, config: HoppingConfig | ChiSquareConfig) -> Method:
    return Method(name, partial(extract_segments, config=config))


def all_methods(sensor: str | None = None) -> tuple[Method, ...]:
    """The paper's, with its own threshold and with the best one for noise spec/3; this project's; and three of the
    field, tuned on TUNING_SEEDS at that noise: split-and-merge, scikit-image's RANSAC, OpenCV's HoughLinesP.

    Ours expects the noise of the sensor of that name, or estimates it from every scan.
    """
    return (
        _slam("paper, printed", HoppingConfig(L_Th=8)),
        _slam("paper, tuned", HoppingConfig(sigma_Th=0.1, L_Th=12)),
        _slam(OURS, chi_square_config(sensor)),
        Method("split-and-merge", SplitAndMerge()),
        Method("RANSAC", Ransac()),
        Method("Hough", ProbabilisticHough()),
    )


def told_the_noise(noise: float) -> Method:
    """Ours, told that the standard deviation is this share of the bound that the maker of the URG-04LX gives."""
    return _slam("ours, noise told", ChiSquareConfig(sensor="urg04lx", bound_sigmas=1.0 / noise))
