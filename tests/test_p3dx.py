"""The base: it goes where its wheels say, within its limits, and its odometry errs only as told."""

from math import hypot, pi, sqrt

import numpy as np
import pytest

from sim.p3dx import TICKS_PER_TURN, TRACK, WHEEL_RADIUS, P3dx, Ticks
from sim.ramp import ramped
from sim.wheel_odometry import WheelOdometry
from sim.world import World
from slam.errors import RobotError
from slam.odometry import Odometry, Twist2D, wheel_motion
from slam.pose import Pose2D, wrap_angle
from slam.run.scenario.robot_config import Limits, WheelErrors

RATE = 240
ORIGIN = Pose2D()
FAST = Limits(acceleration=2.0, deceleration=2.0, angular_acceleration=6.0)
TICKS_PER_METRE = TICKS_PER_TURN / (2.0 * pi * WHEEL_RADIUS)


class Rig:
    """A base on an empty floor with its odometry."""

    def __init__(self, limits: Limits = FAST, start: Pose2D = ORIGIN, **errors: float) -> None:
        self.world = World([], RATE)
        self.base = P3dx(self.world, start, limits)
        rng = np.random.default_rng(0)
        self.odometry = WheelOdometry(WheelErrors(**errors), self.base.read_encoders(), rng)
        self.turned = 0.0

    def go(self, v: float, w: float, seconds: float) -> None:
        """Drive as commanded, the command repeated at every step."""
        for _ in range(round(seconds * RATE)):
            self.base.command(Twist2D(v, w))
            self.step()

    def step(self) -> None:
        theta = self.base.pose.theta
        self.base.control()
        self.world.step()
        self.odometry.add(self.base.read_encoders())
        self.turned += wrap_angle(self.base.pose.theta - theta)

    def read(self) -> Odometry:
        return self.odometry.read(self.world.time)


def test_it_stands_where_it_was_put():
    start = Pose2D(1.0, -2.0, 2.5)
    rig = Rig(start=start)
    motion = start.between(rig.base.pose)
    assert hypot(motion.x, motion.y) < 1e-9
    rig.go(0.0, 0.0, 10.0)
    motion = start.between(rig.base.pose)
    assert hypot(motion.x, motion.y) < 2e-5
    assert abs(motion.theta) < 2e-5


def test_odometry_without_errors_is_true_over_ten_metres():
    start = Pose2D(1.0, 2.0, 0.7)
    rig = Rig(start=start)
    rig.go(1.0, 0.0, 10.0)
    rig.go(0.0, 0.0, 2.0)
    truth, odometry = start.between(rig.base.pose), rig.read().T_odom_base
    assert truth.x == pytest.approx(10.0, rel=5e-4)
    assert abs(truth.y) < 5e-3
    assert truth.distance(odometry) < 5e-3
    assert odometry.theta == pytest.approx(truth.theta, abs=1e-4)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_odometry_without_errors_is_true_over_ten_turns(sense):
    rig = Rig()
    rig.go(0.0, 4.0 * sense, 20.0 * pi / 4.0)
    rig.go(0.0, 0.0, 1.0)
    truth, odometry = rig.base.pose, rig.read().T_odom_base
    assert rig.turned == pytest.approx(20.0 * pi * sense, rel=5e-4)
    assert wrap_angle(odometry.theta - truth.theta) == pytest.approx(0.0, abs=5e-4)
    assert truth.distance(odometry) < 2e-3


def test_odometry_without_errors_is_true_on_a_winding_way():
    rig = Rig(limits=Limits())
    for v, w in [(0.5, 0.8), (0.8, -1.0), (-0.3, 0.4), (0.0, 2.0), (0.6, 0.0), (0.0, 0.0)]:
        rig.go(v, w, 2.0)
    truth, odometry = rig.base.pose, rig.read().T_odom_base
    assert truth.distance(odometry) < 2e-3
    assert wrap_angle(odometry.theta - truth.theta) == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("errors", [{"left_radius": 0.0985}, {"right_radius": 0.0965}, {"track": 0.357}])
def test_a_wrong_calibration_bends_the_odometry_as_the_closed_form_says(errors):
    rig = Rig(**errors)
    rig.go(0.8, 0.4, 6.0)
    believed = WheelErrors(**errors)
    angles = np.array([rig.base.read_encoders().left, rig.base.read_encoders().right]) * 2 * pi / TICKS_PER_TURN
    left, right = angles * [believed.left_radius, believed.right_radius]
    odometry = rig.read().T_odom_base
    assert odometry.theta == pytest.approx(wrap_angle((right - left) / believed.track), abs=1e-9)
    assert rig.base.pose.distance(odometry) > 0.02


def test_a_larger_left_wheel_makes_straight_driving_a_circle():
    rig = Rig(left_radius=WHEEL_RADIUS * 1.01)
    rig.go(1.0, 0.0, 6.0)
    length = rig.base.pose.x
    expected = wheel_motion(1.01 * length, length, TRACK)
    assert rig.read().T_odom_base.distance(expected) < 1e-3
    assert expected.y < -0.3


def test_commands_are_clipped_to_the_limits():
    base = Rig(limits=Limits(linear=0.7, angular=1.5)).base
    assert base.command(Twist2D(0.3, -0.4)) == Twist2D(0.3, -0.4)
    assert base.command(Twist2D(5.0, -9.0)) == Twist2D(0.7, -1.5)
    assert base.command(Twist2D(-5.0, 9.0)) == Twist2D(-0.7, 1.5)


@pytest.mark.parametrize("twist", [Twist2D(float("nan"), 0.0), Twist2D(0.0, float("inf"))])
def test_a_command_must_be_finite(twist):
    with pytest.raises(RobotError, match="finite"):
        Rig().base.command(twist)


def test_speed_follows_the_ramps():
    rig = Rig(limits=Limits())
    rig.go(0.6, 0.0, 1.0)
    assert rig.base.setpoint.linear == pytest.approx(0.3)
    assert rig.base.pose.x == pytest.approx(0.3 / 2, abs=2e-3)
    rig.go(0.6, 0.0, 2.0)
    before = rig.base.pose.x
    rig.go(0.0, 0.0, 2.0)
    assert rig.base.pose.x - before == pytest.approx(0.6**2 / 2 / 0.6, abs=2e-3)
    rig.go(0.0, 5.0, 1.0)
    assert rig.turned == pytest.approx(1.74 / 2, rel=0.01)


def test_a_reversal_falls_through_zero_and_rises_again():
    speeds, speed = [], 0.3
    while speed != -0.3:
        speed = ramped(speed, -0.3, rise=0.1, fall=0.2)
        speeds.append(speed)
    assert speeds == pytest.approx([0.1, 0.0, -0.1, -0.2, -0.3])


def test_the_watchdog_stops_it_two_seconds_after_the_last_command():
    rig = Rig()
    rig.base.command(Twist2D(0.5, 0.0))
    for _ in range(2 * RATE):
        rig.step()
    assert rig.base.setpoint.linear == 0.5
    rig.step()
    assert rig.base.setpoint.linear < 0.5
    for _ in range(RATE):
        rig.step()
    assert rig.base.setpoint == Twist2D()
    stopped = rig.base.pose
    for _ in range(RATE):
        rig.step()
    assert rig.base.pose.distance(stopped) < 1e-4


def test_encoders_count_whole_ticks_of_the_real_wheels():
    rig = Rig()
    rig.go(0.5, 0.0, 2.0)
    ticks = rig.base.read_encoders()
    assert ticks.left == pytest.approx(rig.base.pose.x * TICKS_PER_METRE, rel=1e-3)
    assert 124_800 < TICKS_PER_METRE < 128_000
    assert isinstance(ticks.left, int)


def test_the_twist_of_the_odometry_is_the_mean_since_the_last_reading():
    odometry = WheelOdometry(WheelErrors(), Ticks(100, 100), np.random.default_rng(0))
    odometry.add(Ticks(100 + round(0.1 * TICKS_PER_METRE), 100 + round(0.2 * TICKS_PER_METRE)))
    twist = odometry.read(0.5).twist
    assert twist.linear == pytest.approx(0.3, rel=1e-4)
    assert twist.angular == pytest.approx(0.2 / TRACK, rel=1e-4)
    assert odometry.read(1.0).twist == Twist2D()


@pytest.mark.parametrize("parts", [1, 50])
def test_travel_noise_grows_with_the_root_of_the_distance(parts):
    metres, noise = 4.0, 0.01
    rng = np.random.default_rng(1)
    errors = WheelErrors(travel_noise=noise)
    step = round(metres * TICKS_PER_METRE / parts)
    turns = []
    for _ in range(600):
        odometry = WheelOdometry(errors, Ticks(0, 0), rng)
        for part in range(1, parts + 1):
            odometry.add(Ticks(step * part, step * part))
        turns.append(odometry.read(1.0).T_odom_base.theta * TRACK)
    assert np.std(turns) == pytest.approx(noise * sqrt(metres) * sqrt(2.0), rel=0.1)
    assert abs(np.mean(turns)) < 4 * noise * sqrt(metres) * sqrt(2.0) / sqrt(600)
