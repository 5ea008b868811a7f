"""The line segments of a scan, by the method that the settings name."""

from __future__ import annotations

from slam.config import ChiSquareConfig, HoppingConfig, OwnMethod
from slam.lines.chi_square import segments_by_chi_square
from slam.lines.hopping import segments_by_hopping
from slam.lines.own_extractor import own_segments
from slam.lines.segments import Segments
from slam.scan import LaserScan


def extract_segments(scan: LaserScan, config: HoppingConfig | ChiSquareConfig | OwnMethod) -> Segments:
    """Segments of the scan, sensor frame; they count its points as ``scan.points()`` does."""
    if isinstance(config, OwnMethod):
        return own_segments(scan, config)
    if isinstance(config, ChiSquareConfig):
        return segments_by_chi_square(scan, config)
    return segments_by_hopping(scan.points(), config)
