"""The motion model against the equations of the paper, and its limit for straight motion."""

from math import cos, pi, sin

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from slam.odometry import Twist2D, wheel_motion
from slam.pose import Pose2D, wrap_angle

TRACK = 0.33
travels = st.floats(-1.0, 1.0)
twists = st.builds(Twist2D, st.floats(-2.0, 2.0), st.floats(-5.0, 5.0))
times = st.floats(0.01, 0.6)  # too short for half a turn


def close(a: Twist2D, b: Twist2D) -> bool:
    return abs(a.linear - b.linear) < 1e-9 and abs(a.angular - b.angular) < 1e-9


@given(twists, times)
def test_the_twist_of_a_motion_is_recovered(twist: Twist2D, seconds: float) -> None:
    assert close(Twist2D.from_motion(twist.motion(seconds), seconds), twist)
    assert Twist2D.from_motion(twist.motion(seconds), 0.0) == Twist2D()


@given(twists, times, times)
def test_motions_at_a_constant_twist_compose(twist: Twist2D, first: float, second: float) -> None:
    parts, whole = twist.motion(first) @ twist.motion(second), twist.motion(first + second)
    assert parts.distance(whole) < 1e-9
    assert abs(wrap_angle(parts.theta - whole.theta)) < 1e-9
    back = twist.motion(first) @ twist.motion(-first)
    assert back.distance(Pose2D()) < 1e-9
    assert abs(back.theta) < 1e-9


@given(twists, st.floats(0.1, 1.0))
def test_the_twist_is_recovered_from_the_wheels(twist: Twist2D, track: float) -> None:
    assert close(Twist2D.from_wheels(*twist.to_wheels(track), track), twist)


def printed(left: float, right: float, x: float, y: float, theta: float) -> Pose2D:
    """Eqs. (38) to (42), word for word but for the sign before the radius in eq. (42): see the test below."""
    beta = (right - left) / TRACK
    R = left / beta
    cx = x - (R + TRACK / 2) * sin(theta)
    cy = y + (R + TRACK / 2) * cos(theta)
    turned = (theta + beta) % (2 * pi)
    return Pose2D(cx + (R + TRACK / 2) * sin(turned), cy - (R + TRACK / 2) * cos(turned), turned)


@given(travels, travels, st.floats(-5, 5), st.floats(-5, 5), st.floats(-pi, pi))
def test_the_arc_is_that_of_the_published_equation(left: float, right: float, x: float, y: float, theta: float) -> None:
    assume(abs(left - right) > 1e-4)
    moved, expected = Pose2D(x, y, theta) @ wheel_motion(left, right, TRACK), printed(left, right, x, y, theta)
    assert moved.distance(expected) < 1e-9
    assert abs(wrap_angle(moved.theta - expected.theta)) < 1e-9


@given(travels, travels, st.floats(-pi, pi))
def test_the_minus_sign_of_eq_42_is_a_misprint(left: float, right: float, theta: float) -> None:
    """With the printed sign the robot ends on the opposite side of its circle, twice the radius away."""
    assume(abs(left - right) > 1e-4)
    beta = (right - left) / TRACK
    radius = left / beta + TRACK / 2
    turned = theta + beta
    cx, cy = -radius * sin(theta), radius * cos(theta)
    with_minus = Pose2D(cx - radius * sin(turned), cy + radius * cos(turned), turned)
    assert with_minus.distance(Pose2D(theta=theta) @ wheel_motion(left, right, TRACK)) == pytest.approx(
        2.0 * abs(radius), rel=1e-6, abs=1e-9
    )


@given(travels, st.floats(-1e-6, 1e-6))
def test_almost_straight_motion_is_stable(distance: float, difference: float) -> None:
    motion = wheel_motion(distance - difference / 2, distance + difference / 2, TRACK)
    beta = difference / TRACK
    assert motion.x == pytest.approx(distance, abs=1e-10)
    assert motion.y == pytest.approx(distance * beta / 2, abs=1e-10)
    assert motion.theta == pytest.approx(beta, abs=1e-15)


def test_straight_motion_is_exact() -> None:
    assert wheel_motion(0.7, 0.7, TRACK) == Pose2D(0.7, 0.0, 0.0)  # eqs. (43) and (44)


@given(travels, travels)
def test_driving_back_undoes_the_motion(left: float, right: float) -> None:
    there_and_back = wheel_motion(left, right, TRACK) @ wheel_motion(-left, -right, TRACK)
    assert there_and_back.distance(Pose2D()) < 1e-12
    assert abs(there_and_back.theta) < 1e-12


@given(travels, travels, st.floats(0.01, 0.99))
def test_an_arc_is_the_composition_of_its_halves(left: float, right: float, share: float) -> None:
    parts = wheel_motion(share * left, share * right, TRACK) @ wheel_motion(
        (1 - share) * left, (1 - share) * right, TRACK
    )
    whole = wheel_motion(left, right, TRACK)
    assert parts.distance(whole) < 1e-12


def test_turning_on_the_spot_keeps_the_position() -> None:
    motion = wheel_motion(-TRACK * pi / 4, TRACK * pi / 4, TRACK)
    assert motion.distance(Pose2D()) < 1e-15
    assert motion.theta == pytest.approx(pi / 2)
