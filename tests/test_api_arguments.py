"""Arguments of the API: errors name argument, value, place and fix; unusual but valid forms are accepted."""

import re
from collections.abc import Callable
from decimal import Decimal
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import hopslam

ANGLES = np.linspace(-2.0, 2.0, 101)
RANGES = np.full(101, 2.5)


def with_item(row: np.ndarray, index: int, item: Any) -> list[Any]:
    changed = row.tolist()
    changed[index] = item
    return changed


FAULTS: dict[str, tuple[Any, Any, str]] = {
    "None": (None, ANGLES, r"ranges is None"),
    "None inside": (with_item(RANGES, 3, None), ANGLES, r"ranges\[3\] is None.*inf .*nan"),
    "text inside": (with_item(RANGES, 7, "far"), ANGLES, r"ranges\[7\] is 'far', not a number"),
    "numbers as text": ([str(r) for r in RANGES], ANGLES, r"ranges\[0\] is '2\.5', not a number"),
    "a list inside": (with_item(RANGES, 2, [1.0, 2.0]), ANGLES, r"ranges\[2\] is \[1\.0, 2\.0\], not a number"),
    "truth values": ([True] * 101, ANGLES, r"ranges\[0\] is True"),
    "one number": (2.5, ANGLES, r"ranges has shape \(\).*row of numbers"),
    "a column": (RANGES[:, None], ANGLES, r"ranges has shape \(101, 1\).*numpy\.ravel\(ranges\)"),
    "several scans": (np.stack([RANGES, RANGES]), ANGLES, r"ranges has shape \(2, 101\).*one scan at a time"),
    "nothing": ([], [], r"ranges has 0 values.*3 or more"),
    "too many beams": (np.ones(50_001), np.linspace(0, 1, 50_001), r"ranges: 50,001 beams a scan, over the limit"),
    "negative": (with_item(RANGES, 5, -1.0), ANGLES, r"ranges\[5\] is -1, below 0.*nan"),
    "millimetres": (1000.0 * RANGES + 0.5, ANGLES, r"millimetres.*2500\.5.*divide by 1000"),
    "whole millimetres": (np.full(101, 25), ANGLES, r"millimetres.*divide by 1000"),
    "centimetres": (100.0 * RANGES + 0.5, ANGLES, r"millimetres or centimetres.*250\.5.*divide by 1000 or 100"),
    "no angles": (RANGES, None, r"angles are missing.*radians"),
    "too few angles": (RANGES, ANGLES[:-1], r"angles has 100 values for 101 ranges"),
    "an angle that is nan": (RANGES, with_item(ANGLES, 9, np.nan), r"angles\[9\] is nan"),
    "degrees": (RANGES, np.linspace(-90, 90, 101), r"degrees: angles\[0\] is -90.*numpy\.radians\(angles\)"),
    "more than a turn": (RANGES, np.linspace(-6, 6, 101), r"angles go from -6 to 6, more than one turn"),
    "one bearing": (RANGES, np.zeros(101), r"angles are all 0"),
}


@pytest.mark.parametrize(("ranges", "angles", "message"), FAULTS.values(), ids=FAULTS)
def test_a_wrong_scan_is_named_with_a_fix(ranges: Any, angles: Any, message: str) -> None:
    slam = hopslam.Slam()
    with pytest.raises(hopslam.InputError, match=message) as raised:
        slam.update(ranges, angles)
    assert str(raised.value).startswith("scan 0: ")
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    ("odometry", "message"),
    [
        ((0.0, np.nan, 0.0), r"odometry\[1\], y, is nan"),
        ((0.0, 0.0, 90.0), r"odometry\[2\], theta.*90.*degrees.*radians"),
        ((0.0, 0.0), r"odometry has 2 values; give three: x, y, theta"),
        ((0.0, None, 0.0), r"odometry\[1\] is None"),
        ("home", r"odometry"),
        ((500.0, 0.0, 0.0), r"odometry moves by 500 in one scan.*millimetres"),
        (None, r"odometry is missing.*every scan or with none"),
    ],
)
def test_a_wrong_odometry_is_named_with_a_fix(odometry: Any, message: str) -> None:
    slam = hopslam.Slam()
    slam.update(RANGES, ANGLES, (0.0, 0.0, 0.0))
    with pytest.raises(hopslam.InputError, match=r"^scan 1: .*" + message):
        slam.update(RANGES, ANGLES, odometry)


def test_degrees_in_the_first_odometry_are_named() -> None:
    with pytest.raises(hopslam.InputError, match=r"^scan 0: odometry\[2\], theta, is 90 and looks like degrees"):
        hopslam.Slam().update(RANGES, ANGLES, (0.0, 0.0, 90.0))


@pytest.mark.parametrize(
    ("stamp", "message"),
    [
        (4.9, r"4\.9, not after 5\.0"),
        (5.0, "not after"),
        (np.inf, "not finite"),
        ("now", "'now', not a number"),
        (1.7e18, "nanoseconds; give seconds"),
    ],
)
def test_a_wrong_stamp_is_named_with_a_fix(stamp: Any, message: str) -> None:
    slam = hopslam.Slam()
    slam.update(RANGES, ANGLES, stamp=5.0)
    with pytest.raises(hopslam.InputError, match=r"^scan 1: stamp is .*" + message):
        slam.update(RANGES, ANGLES, stamp=stamp)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"settings": "duration=3"}, r"'duration=3' is not a setting of the method"),
        ({"settings": ["slam.lines.methud=paper"]}, r"^settings: slam\.lines\.methud"),
        ({"settings": "slam.mode=dead_reckoning"}, "looks at no scan"),
        ({"start": (0, 0, 180)}, r"start\[2\].*degrees"),
        ({"T_base_laser": (0, 0)}, "T_base_laser has 2 values"),
        ({"T_base_laser": (200, 0, 0)}, "T_base_laser is 200 from the robot and looks like millimetres"),
        ({"range_min": 3.0, "range_max": 2.0}, "range_max is 2, not 3 or more"),
        ({"range_max": 4000}, "range_max is 4000 and looks like millimetres"),
        ({"time_increment": -1e-4}, "time_increment is -0.0001"),
        ({"saved_map": "nowhere"}, "nowhere.*cannot be read"),
    ],
)
def test_a_wrong_argument_of_slam_is_named(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(hopslam.InputError, match=message):
        hopslam.Slam(**arguments)


ODD: tuple[Any, ...] = (
    b"x", {}, {1: 2}, set(), [[]], object(), (i for i in range(3)), [Decimal(1)] * 101, np.full(101, 1 + 2j),
    [10**400] * 101, np.full(101, 1e308), np.zeros((2, 2)), np.array("x"), memoryview(b"abc"), "1 2 3", len, int,
)  # fmt: skip


@pytest.mark.parametrize("odd", ODD, ids=lambda odd: type(odd).__name__)
def test_odd_values_are_input_errors_of_one_line(odd: Any) -> None:
    calls: list[Callable[[], Any]] = [
        lambda: hopslam.Slam().update(odd, ANGLES),
        lambda: hopslam.Slam().update(RANGES, odd),
        lambda: hopslam.Slam().update(RANGES, ANGLES, odd),
        lambda: hopslam.Slam().update(RANGES, ANGLES, stamp=odd),
        *(lambda name=name: hopslam.Slam(**{name: odd}) for name in ("settings", "start", "range_max", "seed")),
        lambda: hopslam.Localizer(odd),
    ]
    for call in calls:
        with pytest.raises(hopslam.InputError) as raised:
            call()
        assert "\n" not in str(raised.value)
        assert len(str(raised.value)) < 250


@given(st.integers(0, 2**31))
@settings(max_examples=25)
@pytest.mark.filterwarnings("ignore:scan .*none of its")
def test_no_scan_crashes_the_program(seed: int) -> None:
    random = np.random.default_rng(seed)
    slam, count = hopslam.Slam(), int(random.choice([3, 10, 60]))
    for k in range(4):
        angles = random.choice(np.linspace(-3.0, 3.0, max(count // 2, 2)), count)
        angles[0], angles[-1] = -3.1, 3.1
        kinds = random.choice([1.0, 0.0, np.nan, np.inf, -np.inf], count, p=[0.7, 0.1, 0.1, 0.05, 0.05])
        with np.errstate(invalid="ignore"):
            ranges = random.uniform(0.0, 9.0, count) * kinds
        pose = slam.update(ranges, angles, (0.1 * k, 0.0, 0.1 * k)).pose
        assert np.isfinite(pose.as_array()).all()


@given(st.permutations(range(20)), st.floats(-3.0, 3.0))
def test_beams_in_any_order_are_the_same_scan(order: list[int], turn: float) -> None:
    angles = turn + np.linspace(-1.5, 1.5, 20) ** 3 / 2.0  # uneven
    ranges = np.linspace(1.0, 2.0, 20)
    shuffled = hopslam.Scan(ranges[order], angles[order]).points
    expected = np.column_stack([ranges * np.cos(angles), ranges * np.sin(angles)])
    assert np.allclose(shuffled[np.lexsort(shuffled.T)], expected[np.lexsort(expected.T)])


def test_clockwise_and_wrapped_angles_turn_counter_clockwise() -> None:
    ranges = 1.0 + np.arange(90) / 100.0
    plain = hopslam.Scan(ranges, np.arange(90) * 0.05 + 1.0)
    wrapped = (np.arange(90) * 0.05 + 1.0 + np.pi) % (2 * np.pi) - np.pi
    clockwise = hopslam.Scan(ranges[::-1], wrapped[::-1])
    assert np.allclose(plain.points, clockwise.points, atol=1e-9)
    assert (np.diff(clockwise.angles) > 0.0).all()


def test_ranges_of_rep_117_are_understood() -> None:
    ranges = with_item(RANGES, 0, np.inf)
    ranges[1:6] = [np.nan, -np.inf, 0.0, 31.0, 2]
    scan = hopslam.Scan(ranges, ANGLES, range_max=30.0)
    assert len(scan.points) == 101 - 5


@pytest.mark.parametrize("nothing", [np.nan, np.inf, 0.0])
def test_scans_without_a_distance_give_a_warning(nothing: float) -> None:
    slam = hopslam.Slam()
    with pytest.warns(UserWarning, match=r"scan 0: none of its 101 ranges.*sees walls"):
        slam.update(np.full(101, nothing), ANGLES.tolist())
    slam.update(RANGES, ANGLES)
    slam.update(np.full(101, nothing), ANGLES)  # no warning: the lidar has seen something before


def test_masked_and_other_arrays_are_accepted() -> None:
    masked = np.ma.masked_greater(np.linspace(1.0, 3.0, 101), 2.0)
    assert len(hopslam.Scan(masked, ANGLES).points) == 51
    assert len(hopslam.Scan(RANGES.astype(object), ANGLES).points) == 101
    whole = hopslam.Scan([2] * 101, ANGLES.astype(np.float32))
    assert np.allclose(np.hypot(*whole.points.T), 2.0)


def test_scans_are_copied() -> None:
    ranges = RANGES.copy()
    scan = hopslam.Scan(ranges, ANGLES)
    ranges[:] = 0.0
    assert (scan.ranges == 2.5).all()
    with pytest.raises(ValueError, match="read-only"):
        scan.ranges[0] = 1.0


def test_an_unknown_name_lists_the_known_names() -> None:
    with pytest.raises(AttributeError, match=re.escape("no 'Slamm'; it has Estimate")):
        hopslam.Slamm  # noqa: B018
