"""Key scans matched to the whole map."""

from dataclasses import replace

import numpy as np
import pytest

from slam.config import LeastSquaresConfig, SurfelMapConfig
from slam.graph.key_scan import KeyScan
from slam.graph.map_tracking import MAX_WAITING, MapTracking
from slam.graph.single_poses import between, composed
from slam.lidars import Lidar
from slam.mapping.surfel_map import SurfelMap
from slam.pose import FloatArray, Pose2D
from slam.scan import LaserScan

LIDAR = Lidar(angle_min=-np.pi, angle_increment=0.01, beams=629, range_min=0.05, range_max=8.0, scan_time=0.1)
T_MAP_LASER = np.array([0.3, -0.2, 0.4])
ORIGIN = np.zeros(3)


def room_seen_from(pose: FloatArray) -> FloatArray:
    """Facets (F, 7) of the walls of a room of 4 m by 3 m, sensor frame."""
    rows, (c, s) = [], (np.cos(pose[2]), np.sin(pose[2]))
    for normal, distance, half in (((1, 0), 2, 1.4), ((-1, 0), 2, 1.4), ((0, 1), 1.5, 1.9), ((0, -1), 1.5, 1.9)):
        n = np.array(normal, np.float64)
        for along in np.arange(-half, half, 0.15):
            x, y = distance * n + along * np.array([-n[1], n[0]]) - pose[:2]
            rows.append((c * x + s * y, c * y - s * x, c * n[0] + s * n[1], c * n[1] - s * n[0], 1e-5, 5.0, 0.0))
    return np.array(rows)


def key_at(T_local_laser: FloatArray) -> KeyScan:
    """The room seen from ``T_MAP_LASER``, as a key scan whose pose in ``local`` is this one."""
    return KeyScan(T_local_laser, (0,), room_seen_from(T_MAP_LASER), np.full(629, np.inf, np.float32), LIDAR)


def map_of_room() -> SurfelMap:
    surfel_map = SurfelMap(SurfelMapConfig())
    silent = LaserScan(0.0, LIDAR.angle_min, LIDAR.angle_increment, 0.05, 8.0, np.full(629, np.inf))
    for pose in (np.zeros(3), np.array([0.5, 0.2, 1.0]), T_MAP_LASER):
        surfel_map.add(room_seen_from(pose), silent, Pose2D.from_array(pose))
    return surfel_map


def tracked(drift: FloatArray, surfel_map: SurfelMap, T_map_local: FloatArray = ORIGIN) -> FloatArray:
    """Return the pose of the laser in the map (3,) after a drift (3,) since the last key scan."""
    key = key_at(between(T_map_local, T_MAP_LASER + drift))
    found, known = MapTracking(LeastSquaresConfig(), SurfelMapConfig()).follow(key, T_map_local, surfel_map.grid)
    assert known == [key]
    return composed(found, key.T_local_laser)


@pytest.mark.parametrize("drift", [(0.02, 0.0, 0.0), (0.0, -0.03, 0.0), (0.015, 0.02, 0.0002)])
def test_the_map_corrects_drift(drift: tuple[float, float, float]) -> None:
    assert tracked(np.array(drift), map_of_room()) == pytest.approx(T_MAP_LASER, abs=0.004)


def test_the_heading_follows_slowly() -> None:
    turned = tracked(np.array([0.0, 0.0, 0.02]), map_of_room())
    assert 0.01 < turned[2] - T_MAP_LASER[2] < 0.02


def test_the_origin_of_the_local_frame_does_not_matter() -> None:
    drift, far = np.array([0.01, -0.02, 0.0]), np.array([5.0, 2.0, 1.0])
    assert tracked(drift, map_of_room(), far) == pytest.approx(tracked(drift, map_of_room()), abs=1e-9)


def test_an_empty_map_gives_no_correction() -> None:
    drift = np.array([0.02, 0.01, 0.0])
    assert tracked(drift, SurfelMap(SurfelMapConfig())) == pytest.approx(T_MAP_LASER + drift, abs=1e-12)


def test_a_contradicting_scan_gives_no_correction() -> None:
    far = np.array([0.9, 0.7, 0.0])
    assert tracked(far, map_of_room()) == pytest.approx(T_MAP_LASER + far, abs=1e-12)


def broken_key(T_local_laser: FloatArray) -> KeyScan:
    """``key_at``, of a scan that did not fit what came before."""
    return replace(key_at(T_local_laser), broken=True, index=9)


@pytest.mark.parametrize("drift", [(0.9, 0.7, 0.0), (-0.8, 0.4, 0.5), (1.2, 0.0, -0.4)])
def test_after_a_break_the_place_is_searched_for(drift: tuple[float, float, float]) -> None:
    key = broken_key(T_MAP_LASER + np.array(drift))
    tracking = MapTracking(LeastSquaresConfig(), SurfelMapConfig())
    found, known = tracking.follow(key, ORIGIN, map_of_room().grid)
    assert composed(found, key.T_local_laser) == pytest.approx(T_MAP_LASER, abs=0.01)
    assert known == [key]


def test_after_a_break_scans_wait_outside_the_map() -> None:
    tracking, empty = MapTracking(LeastSquaresConfig(), SurfelMapConfig()), SurfelMap(SurfelMapConfig())
    off = T_MAP_LASER + np.array([0.5, 0.0, 0.2])
    first, second = broken_key(off), key_at(off)
    assert tracking.follow(first, ORIGIN, empty.grid)[1] == []
    found, known = tracking.follow(second, ORIGIN, map_of_room().grid)
    assert composed(found, off) == pytest.approx(T_MAP_LASER, abs=0.01)
    assert known == [first, second]


def test_scans_of_an_unknown_place_wait_for_a_limited_time() -> None:
    tracking, empty = MapTracking(LeastSquaresConfig(), SurfelMapConfig()), SurfelMap(SurfelMapConfig())
    keys = [broken_key(T_MAP_LASER), *(key_at(T_MAP_LASER) for _ in range(MAX_WAITING))]
    known = [tracking.follow(key, ORIGIN, empty.grid)[1] for key in keys]
    assert [len(of_key) for of_key in known] == [*[0] * (MAX_WAITING - 1), MAX_WAITING, 1]


def test_a_second_break_drops_the_waiting_scans() -> None:
    tracking, empty = MapTracking(LeastSquaresConfig(), SurfelMapConfig()), SurfelMap(SurfelMapConfig())
    tracking.follow(broken_key(T_MAP_LASER), ORIGIN, empty.grid)
    last = broken_key(T_MAP_LASER)
    assert tracking.follow(last, ORIGIN, map_of_room().grid)[1] == [last]
