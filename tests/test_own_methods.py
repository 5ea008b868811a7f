"""User-defined extractors, matchers and back ends named ``module:name``."""

import json
import re
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hardware.emulator.plant import Plant
from slam.config import ChiSquareConfig, ForceFieldConfig, OwnMethod, PointMapConfig, SlamConfig
from slam.config.section import ALLOWED
from slam.errors import InputError, RobotError
from slam.files.maps.file import read_map
from slam.line_slam import LineSlam
from slam.lines.chi_square import segments_by_chi_square
from slam.lines.extraction import extract_segments
from slam.lines.segments import Segments
from slam.matching.paper_mapper import PaperMapper
from slam.named_code import import_by_name
from slam.odometry import Odometry
from slam.pose import FloatArray, Pose2D
from slam.run.backends import PLANT_PARTS, make_robot
from slam.run.experiment_setup import scenario_experiment
from slam.scan import LaserScan
from slam.scenario.file import load_scenario

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


def test_the_named_extractor_is_called(here: str, scan_of: Scanner, room: FloatArray) -> None:
    scan = scan_of(room, Pose2D(), 1)
    config = own({"lines": {"method": f"{here}:same_as_ours", "options": {"min_points": 9}}})
    ours = segments_by_chi_square(scan, ChiSquareConfig(min_points=9))
    assert np.array_equal(extract_segments(scan, config.lines).rho, ours.rho)


def test_the_named_matcher_is_called(here: str, scan_of: Scanner, room: FloatArray) -> None:
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
def test_a_missing_method_is_reported(place: str, says: str) -> None:
    with pytest.raises(InputError, match=says):
        import_by_name(place)


def test_a_saved_map_needs_the_matcher_that_made_it(here: str, tmp_path: Path) -> None:
    config = SlamConfig(matching=OwnMethod(method=f"{here}:same_as_papers"))
    with pytest.raises(InputError, match="matched by least_squares"):
        read_map(tmp_path / "map.json", config)


FAULTY = """
from dataclasses import replace
from types import SimpleNamespace
import numpy as np
from slam.config import ChiSquareConfig, HoppingConfig
from slam.lines.extraction import extract_segments
from slam.lines.range_noise import RangeNoise
from slam.lines.segments import Segments
from slam.matching.match import NO_MATCH
from slam.pose import Pose2D

def split(scan, tolerance=0.04, gap=0.3): return []
def ragged(scan): return Segments(*[np.zeros(2)] * 4, np.zeros((3, 2)), np.zeros((2, 2)))
def tires(scan, seen=[]):
    seen.append(scan)
    return extract_segments(scan, ChiSquareConfig()) if len(seen) < 40 else 1 / 0
def fails(scan):
    return 1 / 0
def blind(): return None
def spoilt(scan, field="rho", value=float("nan"), place=1):
    segments = extract_segments(scan, ChiSquareConfig())
    getattr(segments, field)[place] = value
    return segments
def other(scan, field="rho", value=None):
    value = RangeNoise(*value) if field == "noise" else np.array(value)
    return replace(extract_segments(scan, ChiSquareConfig()), **{field: value})
def none(scan): return Segments(*[np.array([])] * 4, *[np.empty((0, 2))] * 2)
def papers(scan): return extract_segments(scan, HoppingConfig())
def few_bits(scan):
    segments = extract_segments(scan, ChiSquareConfig())
    return replace(segments, first=segments.first.astype(np.uint16), rho=segments.rho[::-1].copy()[::-1])
number = 3

class Bare:
    def __init__(self, T_base_laser, seed, reach=1.0): pass
class Careless:
    def __init__(self, T_base_laser, seed): "a" + 1
class Map:
    points, ends = np.empty((0, 2)), np.empty((0, 2, 2))
    def __len__(self): return 0
class Wrong:
    points = lines = Map()
    def __init__(self, T_base_laser, seed): pass
    def locate(self, scan, segments, prior): return prior
    def add(self, scan, segments, T_map_laser): pass
class Nowhere(Wrong):
    def __init__(self, T_base_laser, seed, **fields): self.fields = fields
    def locate(self, scan, segments, prior):
        made = {name: Pose2D(*value) if name[0] == "T" else value and np.array(value) if name[0] in "cu" else value
                for name, value in self.fields.items()}
        return replace(NO_MATCH, **made)
class Endless(Nowhere):
    def locate(self, scan, segments, prior): return NO_MATCH
    @property
    def points(self): return SimpleNamespace(points=np.array([[0.0, np.inf]]), __len__=lambda: 1)
    @property
    def lines(self): return SimpleNamespace(ends=[[0, 0], [1, 1]])

class Mute:
    T_base_laser = Pose2D()
    def __init__(self, scenario, seed=None): pass
    def __enter__(self): return self
    def __exit__(self, *error): pass
    def observe(self, timeout=1.0): return 5
    def drive(self, command): return None
class Seedless(Mute):
    def __init__(self, scenario): pass
class Broken(Mute):
    def observe(self, timeout=1.0): raise OSError("gone")
"""


@pytest.fixture
def faulty(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The module ``faulty``, and ``broken``, which is not Python."""
    (tmp_path / "faulty.py").write_text(FAULTY)
    (tmp_path / "broken.py").write_text("def f(:")
    monkeypatch.syspath_prepend(tmp_path)
    yield
    sys.modules.pop("faulty", None)


@pytest.mark.usefixtures("faulty")
@pytest.mark.parametrize(
    ("setting", "says"),
    [
        ("lines.method=faulty:split", "faulty:split returned list, not Segments"),
        ("lines={method: 'faulty:split', options: {foo: 1}}", "takes no option 'foo'; it takes tolerance, gap"),
        ("lines.method=faulty:ragged", r"faulty:ragged returned Segments whose start is of shape (3, 2)"),
        ("lines.method=faulty:fails", "faulty:fails: ZeroDivisionError: division by zero ("),
        ("lines.method=faulty:blind", "faulty:blind does not take what it is called with: too many positional"),
        ("lines.method=faulty:number", "faulty:number is of type int; a function or a class belongs here"),
        ("lines.method=broken:f", "broken:f: SyntaxError: invalid syntax ("),
        ("matching.method=faulty:Bare", "faulty:Bare is not a valid matcher: Bare has no locate, add, points, lines"),
        ("matching={method: 'faulty:Bare', options: {foo: 1}}", "faulty:Bare takes no option 'foo'; it takes reach"),
        ("matching.method=faulty:Careless", "faulty:Careless: TypeError: can only concatenate str"),
        ("matching.method=faulty:Wrong", "faulty:Wrong.locate returned Pose2D, not Match"),
    ],
)
def test_errors_of_own_code_are_one_line_with_its_name(
    setting: str, says: str, scan_of: Scanner, room: FloatArray
) -> None:
    config = load_scenario("corridor", [f"slam.{setting}"]).slam
    with pytest.raises(InputError, match=re.escape(says)) as raised:
        LineSlam(config, Pose2D()).update(scan_of(room, Pose2D(), 1), Odometry(0.0, Pose2D()))
    assert "\n" not in str(raised.value)


SPOILT = "returned Segments whose "


@pytest.mark.usefixtures("faulty")
@pytest.mark.parametrize(
    ("method", "options", "says"),
    [
        ("spoilt", "{field: last, value: 99999}", f"{SPOILT}first[1] is "),
        ("spoilt", "{field: last, value: 99999}", "last[1] is 99999, not 0 <= first <= last < "),
        ("spoilt", "{field: first, value: -1, place: 0}", f"{SPOILT}first[0] is -1"),
        ("spoilt", "{field: last, value: 0}", "last[1] is 0, not 0 <= first"),
        ("spoilt", "{field: first, value: 0}", f"{SPOILT}first[1] is 0, before last[0]"),
        ("spoilt", "{field: rho}", f"{SPOILT}rho[1] is nan, not a finite number"),
        ("spoilt", "{field: theta, value: .inf}", f"{SPOILT}theta[1] is inf"),
        ("spoilt", "{field: start}", f"{SPOILT}start[1, 0] is nan"),
        ("spoilt", "{field: end, value: -.inf}", f"{SPOILT}end[1, 0] is -inf"),
        ("spoilt", "{field: covariance}", f"{SPOILT}covariance[1, 0, 0] is nan"),
        ("spoilt", "{field: end_covariance}", f"{SPOILT}end_covariance[1, 0, 0] is nan"),
        ("other", "{field: rho, value: 3}", f"{SPOILT}rho is of shape ()"),
        ("other", "{field: first, value: [0.5]}", f"{SPOILT}first is of shape (1,)"),
        ("other", "{field: covariance, value: [[1, 0], [0, 1]]}", f"{SPOILT}covariance is of shape (2, 2)"),
        ("other", "{field: noise, value: [.nan, 1, 0.01, 0.01]}", f"{SPOILT}noise.near is nan"),
        ("other", "{field: noise, value: [0, 1, 0.01, 0]}", f"{SPOILT}noise is RangeNoise(near=0"),
        ("Nowhere", "{T_prior_laser: [.nan]}", ".locate returned a Match whose T_prior_laser.x is nan"),
        ("Nowhere", "{T_prior_laser: [0, 0, .inf]}", "T_prior_laser.theta is inf"),
        ("Nowhere", "{T_prior_laser: [0, here]}", "T_prior_laser.y is 'here'"),
        ("Nowhere", "{inliers: .nan}", "Match whose inliers is nan"),
        ("Nowhere", "{covariance: [[1, 0], [0, 1]]}", "covariance is of shape (2, 2), not an array of shape (3, 3)"),
        ("Nowhere", "{unconstrained: [1, 0, 0]}", "unconstrained is of shape (3,), not an array of shape (K, 3)"),
    ],
)
def test_unusable_numbers_of_own_code_are_named(
    method: str, options: str, says: str, scan_of: Scanner, room: FloatArray
) -> None:
    part = "matching" if method == "Nowhere" else "lines"
    config = load_scenario("corridor", [f"slam.{part}={{method: 'faulty:{method}', options: {options}}}"]).slam
    with pytest.raises(InputError, match=re.escape(says)) as raised:
        LineSlam(config, Pose2D()).update(scan_of(room, Pose2D(), 1), Odometry(0.0, Pose2D()))
    assert str(raised.value).startswith(f"faulty:{method}")
    assert "\n" not in str(raised.value)


@pytest.mark.usefixtures("faulty")
def test_a_map_of_own_code_that_cannot_be_shown_is_named() -> None:
    slam = LineSlam(load_scenario("corridor", ["slam.matching.method=faulty:Endless"]).slam, Pose2D())
    with pytest.raises(InputError, match=re.escape("faulty:Endless.points.points[0, 1] is inf, not a finite number")):
        _ = slam.mapper.points.points
    with pytest.raises(
        InputError, match=r"faulty:Endless\.lines\.ends is of type list, not an array of shape \(K, 2, 2\)"
    ):
        _ = slam.mapper.lines.ends


@pytest.mark.usefixtures("faulty")
def test_an_extractor_may_find_nothing_or_share_corners(scan_of: Scanner, room: FloatArray) -> None:
    scan = scan_of(room, Pose2D(), 1)
    ours = segments_by_chi_square(scan, ChiSquareConfig())
    nothing, same, papers = (
        extract_segments(scan, load_scenario("corridor", [f"slam.lines.method=faulty:{name}"]).slam.lines)
        for name in ("none", "few_bits", "papers")
    )
    assert (len(nothing), nothing.first.dtype) == (0, np.int64)
    assert np.array_equal(same.counts, ours.counts)
    assert same.first.dtype == np.int64
    assert same.rho.flags.c_contiguous
    assert (papers.first[1:] == papers.last[:-1]).any()  # its neighbours share the corner


@pytest.mark.usefixtures("faulty")
@pytest.mark.parametrize(
    ("backend", "error", "says"),
    [
        ("faulty:Mute", RobotError, "faulty:Mute.observe returned int, not Observation"),
        ("faulty:Broken", RobotError, "faulty:Broken.observe: OSError: gone ("),
        ("faulty:Seedless", InputError, "faulty:Seedless does not take what it is called with"),
        ("faulty:Map", InputError, "faulty:Map"),
        ("faulty:Nobody", InputError, "faulty:Nobody: module 'faulty' has no attribute 'Nobody'"),
        (":x", InputError, "no robot back end named ':x'"),
    ],
)
def test_errors_of_an_own_back_end_are_reported(backend: str, error: type[Exception], says: str) -> None:
    with pytest.raises(error, match=re.escape(says)):
        make_robot(backend, load_scenario("corridor"), seed=0).observe()


@pytest.mark.usefixtures("faulty")
def test_failing_own_code_leaves_a_complete_folder(tmp_path: Path) -> None:
    scenario = load_scenario("corridor", ["duration=9", "slam.lines.method=faulty:tires"])
    outcome = scenario_experiment(scenario).run(tmp_path / "run", pictures=False)
    assert (outcome.ending, type(outcome.error)) == ("failed", InputError)
    metrics = json.loads((tmp_path / "run" / "metrics.json").read_text())
    assert 0 < metrics["scans"] < 40
    assert "faulty:tires: ZeroDivisionError" in metrics["error"]


def test_the_check_of_plants_covers_the_protocol() -> None:
    assert set(PLANT_PARTS) == {name for name in vars(Plant) if not name.startswith("_")}
