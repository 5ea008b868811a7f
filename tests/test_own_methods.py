"""Extractors and matchers that are named ``module:name``."""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from slam.config import ChiSquareConfig, ForceFieldConfig, OwnMethod, PointMapConfig, SlamConfig
from slam.config.own import ALLOWED
from slam.errors import InputError
from slam.late import late
from slam.line_slam import LineSlam
from slam.lines.chi_square import segments_by_chi_square
from slam.lines.extraction import extract_segments
from slam.lines.segments import Segments
from slam.matching.paper_mapper import PaperMapper
from slam.odometry import Odometry
from slam.pose import FloatArray, Pose2D
from slam.run.maps.file import read_map
from slam.scan import LaserScan

Scanner = Callable[[FloatArray, Pose2D, int], LaserScan]


def same_as_ours(scan: LaserScan, min_points: int) -> Segments:
    return segments_by_chi_square(scan, ChiSquareConfig(min_points=min_points))


def same_as_papers(T_base_laser: Pose2D, seed: int) -> PaperMapper:
    return PaperMapper(PointMapConfig(), ForceFieldConfig(), T_base_laser, seed)


@pytest.fixture
def here(monkeypatch: pytest.MonkeyPatch) -> str:
    """The name of this module, by which a scenario finds it."""
    monkeypatch.setitem(sys.modules, "own_methods", sys.modules[__name__])
    return "own_methods"


def own(settings: dict[str, Any]) -> SlamConfig:
    """The configuration, with the code of this module allowed."""
    return SlamConfig.model_validate(settings, context={ALLOWED: ("own_methods",)})


def test_an_extractor_named_is_the_one_called(here: str, scan_of: Scanner, room: FloatArray) -> None:
    scan = scan_of(room, Pose2D(), 1)
    config = own({"lines": {"method": f"{here}:same_as_ours", "options": {"min_points": 9}}})
    ours = segments_by_chi_square(scan, ChiSquareConfig(min_points=9))
    assert np.array_equal(extract_segments(scan, config.lines).rho, ours.rho)


def test_a_matcher_named_is_the_one_called(here: str, scan_of: Scanner, room: FloatArray) -> None:
    paper = {"lines": {"method": "paper"}, "deskew": False}
    named = own(paper | {"matching": {"method": f"{here}:same_as_papers"}})
    poses = []
    for config in (named, SlamConfig(mode="paper")):
        slam = LineSlam(config, Pose2D(), seed=3)
        for k in range(3):
            slam.update(scan_of(room, Pose2D(0.01 * k), k), Odometry(0.1 * k, Pose2D()))
        poses.append(slam.T_map_base)
    assert poses[0] == poses[1] != Pose2D()


@pytest.mark.parametrize(
    ("place", "says"),
    [
        ("no_such_module:f", "finds no module no_such_module; put its folder on PYTHONPATH"),
        ("slam.pose:no_such_name", "module 'slam.pose' has no attribute 'no_such_name'"),
    ],
)
def test_what_is_not_there_is_said(place: str, says: str) -> None:
    with pytest.raises(InputError, match=says):
        late(place)


def test_a_saved_map_needs_the_matcher_that_made_it(here: str, tmp_path: Path) -> None:
    config = SlamConfig(matching=OwnMethod(method=f"{here}:same_as_papers"))
    with pytest.raises(InputError, match="matched by least_squares"):
        read_map(tmp_path / "map.json", config)
