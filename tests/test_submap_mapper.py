"""The front end of the graph: overlapping submaps, breaks, and the submaps of key scans."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from slam.config import SlamConfig
from slam.graph.key_scan import KeyScan
from slam.graph.submap_mapper import MIN_KEYS, OPEN, SUBMAPS, SubmapMapper
from slam.line_slam import LineSlam
from slam.odometry import Odometry
from slam.pose import FloatArray, Pose2D
from tests.conftest import Scanner

TO_AND_FRO = [Pose2D(3.0 * np.sin(0.04 * k), 0.3, 0.0) for k in range(240)]
"""A path of 18 m in the room."""


def keys_of(
    path: Sequence[Pose2D], wheels: Sequence[Pose2D], corners: Sequence[FloatArray], scan_of: Scanner
) -> tuple[list[KeyScan], SubmapMapper]:
    slam, keys = LineSlam(SlamConfig(), Pose2D()), []
    assert isinstance(slam.mapper, SubmapMapper)
    slam.loops = None
    for k, (pose, wheel) in enumerate(zip(path, wheels, strict=True)):
        scan = scan_of(corners[k], pose, k)
        slam.update(scan, Odometry(scan.stamp, wheel))
        if slam.mapper.key is not None:
            keys.append(slam.mapper.key)
    return keys, slam.mapper


def test_submaps_overlap_and_replace_each_other(scan_of: Scanner, room: FloatArray) -> None:
    """Their numbers are consecutive, and every key scan belongs to the last two."""
    keys, mapper = keys_of(TO_AND_FRO, TO_AND_FRO, [room] * 240, scan_of)
    assert keys[0].submaps == (0,)
    assert keys[-1].submaps[-1] == 4
    for before, key in pairwise(keys):
        assert len(key.submaps) <= SUBMAPS
        assert key.submaps == before.submaps or key.submaps[-1] == before.submaps[-1] + 1
        assert key.submaps == tuple(range(max(0, key.submaps[-1] - SUBMAPS + 1), key.submaps[-1] + 1))
    numbers = [key.submaps[-1] for key in keys]
    assert min(numbers.count(n) for n in range(numbers[-1])) >= MIN_KEYS
    assert not any(key.broken for key in keys)
    assert len(mapper._open) == OPEN
    assert mapper.map is mapper._open[0]


def test_a_break_begins_a_submap_that_shares_no_scan(scan_of: Scanner, room: FloatArray) -> None:
    """The robot is carried into a narrow round tower while the wheels stand."""
    tower = 0.8 * np.array([[np.cos(t), np.sin(t)] for t in np.linspace(0.0, 2.0 * np.pi, 14)])
    inside = [Pose2D(0.002 * k, 0.1, 0.02 * k) for k in range(40)]
    last = TO_AND_FRO[79]
    wheels = [*TO_AND_FRO[:80], *(last @ inside[0].inverse() @ pose for pose in inside)]
    keys, _ = keys_of([*TO_AND_FRO[:80], *inside], wheels, [room] * 80 + [tower] * 40, scan_of)
    breaks = [n for n, key in enumerate(keys) if key.broken]
    assert len(breaks) == 1
    before, first = keys[breaks[0] - 1], keys[breaks[0]]
    assert first.submaps == (before.submaps[-1] + 1,)
    assert first.trust == 0.0
    assert all(key.submaps[0] > before.submaps[-1] for key in keys[breaks[0] :])


def test_the_same_input_gives_the_same_bits(scan_of: Scanner, room: FloatArray) -> None:
    first, second = (keys_of(TO_AND_FRO[:120], TO_AND_FRO[:120], [room] * 120, scan_of)[0] for _ in range(2))
    assert len(first) == len(second)
    for one, other in zip(first, second, strict=True):
        assert one.submaps == other.submaps
        assert one.T_local_laser.tobytes() == other.T_local_laser.tobytes()
        assert one.facets.tobytes() == other.facets.tobytes()
        assert one.information.tobytes() == other.information.tobytes()
