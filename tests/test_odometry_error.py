"""The errors of the wheels that the back end learns, on drives where the true errors are known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slam.graph.key_scan import KeyScan
from slam.graph.odometry_error import FLOOR, GUESS, MIN_SIGMAS, MIN_STEPS, OdometryError, is_sure, motion_errors
from slam.lidars import TABLE1
from slam.pose import FloatArray, compose_poses

SURE = np.diag([1e6, 1e6, 1e6])
MOTION = np.array([0.5, 0.0, 0.2])


def keys_of(wheels: FloatArray, information: FloatArray = SURE, broken: bool = False) -> list[KeyScan]:
    """Key scans that move by MOTION each, and what the wheels (N, 3) say of that."""
    keys, pose = [], np.zeros(3)
    for k, wheel in enumerate(wheels):
        keys.append(KeyScan(
            pose, (0,), np.empty((0, 7)), np.empty(0, np.float32), TABLE1.lidar,
            information=information, wheel_motion=wheel, index=k, broken=broken,
        ))  # fmt: skip
        pose = compose_poses(pose, MOTION)
    return keys


def wheels_of(count: int, sigmas: tuple[float, float, float]) -> FloatArray:
    """Motions (N, 3) of wheels that err by these standard deviations: metres and radians."""
    return np.asarray(MOTION + np.array(sigmas) * np.random.default_rng(0).standard_normal((count, 3)))


def learnt(keys: list[KeyScan]) -> FloatArray:
    return OdometryError.learnt(keys, np.arange(len(keys)) > 0).sigmas


def test_errors_are_learned_per_metre() -> None:
    """A motion of 0.5 m and 0.2 rad counts as 0.6 m."""
    sigmas = (0.03, 0.02, 0.01)
    np.testing.assert_allclose(learnt(keys_of(wheels_of(2000, sigmas))), np.array(sigmas) / 0.6, rtol=0.08)


def test_a_few_wrong_motions_change_little() -> None:
    wheels = wheels_of(2000, (0.03, 0.02, 0.01))
    slipped = wheels.copy()
    slipped[::10, 0] += 2.0
    np.testing.assert_allclose(learnt(keys_of(slipped)), learnt(keys_of(wheels)), rtol=0.2)


def test_wheel_errors_never_become_zero() -> None:
    np.testing.assert_array_equal(learnt(keys_of(np.tile(MOTION, (50, 1)))), MIN_SIGMAS)


def test_too_few_sure_motions_change_nothing() -> None:
    wheels = wheels_of(200, (0.03, 0.02, 0.01))
    unsure_ahead = np.diag([1.0, 1e6, 1e6])
    for keys in (keys_of(wheels[:MIN_STEPS]), keys_of(wheels, unsure_ahead), keys_of(wheels, broken=True)):
        np.testing.assert_array_equal(learnt(keys), GUESS)
    assert (learnt(keys_of(wheels[: MIN_STEPS + 1])) != GUESS).all()
    assert not any(is_sure(key) for key in keys_of(wheels, unsure_ahead))


def test_standing_still_changes_nothing() -> None:
    keys = keys_of(np.zeros((50, 3)))
    np.testing.assert_array_equal(learnt(keys), GUESS)


def test_errors_are_along_and_across_the_motion() -> None:
    """First the wheels move 1 m to the left, while the scans move 0.5 m ahead; then both move alike."""
    keys = keys_of(np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 0.2], [0.5, 0.0, 0.2]]))
    errors = motion_errors(keys, np.array([False, True, True]))
    np.testing.assert_allclose(errors[0], 0.0)
    np.testing.assert_allclose(errors[1], [1.0, 0.5, 0.0], atol=1e-12)
    np.testing.assert_allclose(errors[2], 0.0, atol=1e-12)
    assert not motion_errors(keys, np.array([False, False, True]))[1].any()


@given(st.floats(-3.0, 3.0), st.floats(0.1, 2.0), st.floats(-0.5, 0.5))
def test_the_covariance_turns_with_the_motion(heading: float, way: float, turn: float) -> None:
    error, off = OdometryError(np.array([0.1, 0.02, 0.03])), np.array([0.01, 0.05, 0.02])
    c, s = np.cos(heading), np.sin(heading)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    ahead = error.covariance(np.array([way, 0.0, turn]), off)
    turned = error.covariance(np.array([way * c, way * s, turn]), off)
    np.testing.assert_allclose(turned, R @ ahead @ R.T, atol=1e-12)
    expected = (error.sigmas * (way + 0.5 * abs(turn))) ** 2 + off**2 + FLOOR**2
    np.testing.assert_allclose(ahead, np.diag(expected))


def test_no_motion_has_the_smallest_covariance() -> None:
    found = OdometryError(np.array(GUESS)).covariance(np.zeros(3), np.zeros(3))
    assert found == pytest.approx(np.diag(FLOOR**2))
