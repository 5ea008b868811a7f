"""The base: motion, limits and odometry errors."""

from math import hypot, pi, sqrt
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.controller import Controller
from sim.firmware import ramped
from sim.p3dx import P3dx
from sim.records import model_of
from sim.wheels import ANGLE_UNIT, MILLIMETRE, TICKS_PER_TURN, TRACK, WHEEL_RADIUS
from sim.world import World
from slam.assets import asset
from slam.errors import RobotError
from slam.odometry import Twist2D, wheel_motion
from slam.pose import Pose2D, wrap_angle
from slam.scenario.robot_config import Limits, RobotConfig, Traction, WheelErrors

RATE = 240
ORIGIN = Pose2D()
FAST = Limits(acceleration=2.0, deceleration=2.0, angular_acceleration=6.0)
NO_LOSS = Traction()
TICKS_PER_METRE = TICKS_PER_TURN / (2.0 * pi * WHEEL_RADIUS)


class Rig:
    """A base on an empty floor with its odometry, which is not rounded."""

    def __init__(
        self, limits: Limits = FAST, start: Pose2D = ORIGIN, traction: Traction = NO_LOSS, **errors: float
    ) -> None:
        place = {"x": start.x, "y": start.y, "theta": start.theta}
        believed = WheelErrors(firmware_units=False, **errors)
        config = RobotConfig(start=place, limits=limits, traction=traction, odometry=believed, control_rate=RATE)
        self.world = World([], RATE)
        self.base = P3dx(self.world, config)
        self.controller = self.base.controller
        self.turned = 0.0

    def go(self, v: float, w: float, seconds: float) -> None:
        """Give this command at every step."""
        for _ in range(round(seconds * RATE)):
            self.controller.command(Twist2D(v, w))
            self.step()

    def step(self) -> None:
        theta = self.base.pose.theta
        self.base.control()
        self.world.step()
        self.base.read_wheels()
        self.turned += wrap_angle(self.base.pose.theta - theta)


def controller_of(**errors: object) -> Controller:
    """A controller whose wheels are turned by ``roll``."""
    return Controller(RobotConfig(odometry=WheelErrors.model_validate(errors)), RATE)


def roll(controller: Controller, left: int, right: int) -> None:
    """Turn the wheels to these counts of ticks since the start, and read the encoders."""
    angles = np.array([left, right]) * 2.0 * pi / TICKS_PER_TURN
    controller.read_wheels((angles[0], 0.0, (), 0.0), (angles[1], 0.0, (), 0.0))


def test_the_robot_starts_at_its_given_pose() -> None:
    start = Pose2D(1.0, -2.0, 2.5)
    rig = Rig(start=start)
    motion = start.between(rig.base.pose)
    assert hypot(motion.x, motion.y) < 1e-9
    rig.go(0.0, 0.0, 10.0)
    motion = start.between(rig.base.pose)
    assert hypot(motion.x, motion.y) < 2e-5
    assert abs(motion.theta) < 2e-5


def test_odometry_without_errors_is_true_over_ten_metres() -> None:
    start = Pose2D(1.0, 2.0, 0.7)
    rig = Rig(start=start)
    rig.go(1.0, 0.0, 10.0)
    rig.go(0.0, 0.0, 2.0)
    truth, odometry = start.between(rig.base.pose), rig.controller.odometry
    assert truth.x == pytest.approx(10.0, rel=5e-4)
    assert abs(truth.y) < 5e-3
    assert truth.distance(odometry) < 5e-3
    assert odometry.theta == pytest.approx(truth.theta, abs=1e-4)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_odometry_without_errors_is_true_over_ten_turns(sense: float) -> None:
    rig = Rig()
    rig.go(0.0, 4.0 * sense, 20.0 * pi / 4.0)
    rig.go(0.0, 0.0, 1.0)
    truth, odometry = rig.base.pose, rig.controller.odometry
    assert rig.turned == pytest.approx(20.0 * pi * sense, rel=5e-4)
    assert wrap_angle(odometry.theta - truth.theta) == pytest.approx(0.0, abs=5e-4)
    assert truth.distance(odometry) < 2e-3


def test_odometry_without_errors_is_true_on_a_winding_path() -> None:
    rig = Rig(limits=Limits())
    for v, w in [(0.5, 0.8), (0.8, -1.0), (-0.3, 0.4), (0.0, 2.0), (0.6, 0.0), (0.0, 0.0)]:
        rig.go(v, w, 2.0)
    truth, odometry = rig.base.pose, rig.controller.odometry
    assert truth.distance(odometry) < 2e-3
    assert wrap_angle(odometry.theta - truth.theta) == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("errors", [{"left_radius": 0.0985}, {"right_radius": 0.0965}, {"track": 0.357}])
def test_a_wrong_calibration_bends_odometry_in_closed_form(errors: Any) -> None:
    rig = Rig(**errors)
    rig.go(0.8, 0.4, 6.0)
    believed = WheelErrors(**errors)
    angles = np.array(rig.controller.ticks) * 2 * pi / TICKS_PER_TURN
    left, right = angles * [believed.left_radius, believed.right_radius]
    odometry = rig.controller.odometry
    assert odometry.theta == pytest.approx(wrap_angle((right - left) / believed.track), abs=1e-9)
    assert rig.base.pose.distance(odometry) > 0.02


def test_a_wrong_wheel_radius_drives_an_unnoticed_circle() -> None:
    rig = Rig(left_radius=WHEEL_RADIUS * 1.01)
    rig.go(1.0, 0.0, 6.0)
    odometry = rig.controller.odometry
    assert abs(odometry.y) < 1e-3
    expected = wheel_motion(odometry.x / 1.01, odometry.x, TRACK)
    assert rig.base.pose.distance(expected) < 1e-3
    assert expected.y > 0.3


def square(rig: Rig, sense: float, side: float) -> tuple[Pose2D, Pose2D]:
    """Drive a square by the odometry; return the true end and the end by the odometry."""
    a, wa = FAST.acceleration, FAST.angular_acceleration
    for _ in range(4):
        rig.go(1.0, 0.0, side)  # the way lost while it speeds up is driven while it slows down
        rig.go(0.0, 0.0, 1.0 / a + 0.1)
        rig.go(0.0, 1.0 * sense, pi / 2)
        rig.go(0.0, 0.0, 1.0 / wa + 0.1)
    return rig.base.pose, rig.controller.odometry


def borenstein_feng(side: float, sense: float, alpha: float, beta: float) -> tuple[float, float]:
    """End point of a square that begins and should end at 0 (UMBmark), to the first order.

    Borenstein and Feng, "Measurement and correction of systematic odometry errors in mobile robots", 1996: ``alpha``
    radians are turned too much at each corner, in either sense, and ``beta`` radians to the left on each side.
    """
    return 2.0 * side * (alpha + sense * beta), -2.0 * side * (beta + sense * alpha)


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("errors", [{"track": 1.001}, {"right_radius": 1.0003}])
def test_a_square_both_ways_drifts_as_borenstein_and_feng_say(sense: float, errors: Any) -> None:
    side = 4.0
    known = {"track": TRACK, "right_radius": WHEEL_RADIUS}
    rig = Rig(**{name: known[name] * factor for name, factor in errors.items()})
    truth, odometry = square(rig, sense, side)
    drift = odometry.between(truth)
    lag = 1.0 / errors.get("right_radius", 1.0) - 1.0  # excess of the right wheel's way over the odometry
    alpha = pi / 2 * (errors.get("track", 1.0) - 1.0) + pi / 4 * lag
    beta = side / TRACK * lag
    expected = borenstein_feng(side, sense, alpha, beta)
    assert np.allclose([drift.x, drift.y], expected, atol=0.01 * hypot(*expected))


@pytest.mark.parametrize(
    "traction", [Traction(slip=0.05), Traction(effective_track=0.357), Traction(slip=0.02, effective_track=0.4)]
)
def test_slip_and_scrub_shorten_the_true_motion(traction: Any) -> None:
    rig = Rig(traction=traction)
    rig.go(0.8, 0.0, 4.0)
    rig.go(0.0, 0.0, 1.0)
    assert rig.base.pose.x == pytest.approx((1.0 - traction.slip) * rig.controller.odometry.x, rel=5e-4)
    rig.go(0.0, 1.0, 3.0)
    rig.go(0.0, 0.0, 1.0)
    reported = rig.controller.odometry.theta
    assert rig.turned == pytest.approx((1.0 - traction.slip) * TRACK / traction.effective_track * reported, rel=1e-3)


def test_a_firmware_that_knows_the_effective_track_turns_right() -> None:
    rig = Rig(traction=Traction(effective_track=0.357), track=0.357)
    rig.go(0.0, 1.0, 3.0)
    rig.go(0.0, 0.0, 1.0)
    assert rig.turned == pytest.approx(3.0, rel=1e-3)
    assert rig.controller.odometry.theta == pytest.approx(rig.turned, rel=1e-3)


@given(st.floats(0.0, 0.9), st.floats(0.2, 0.6), st.floats(-50.0, 50.0), st.floats(-50.0, 50.0))
def test_slip_and_scrub_back_are_the_inverse(slip: float, effective_track: float, left: float, right: float) -> None:
    (model,) = model_of(RobotConfig(traction=Traction(slip=slip, effective_track=effective_track)), RATE)
    there = np.array([[model["own_gain"], model["cross_gain"]], [model["cross_gain"], model["own_gain"]]])
    back = np.array(
        [
            [model["own_gain_inverse"], -model["cross_gain_inverse"]],
            [-model["cross_gain_inverse"], model["own_gain_inverse"]],
        ]
    )
    assert back @ there @ [left, right] == pytest.approx([left, right], abs=1e-9)


def test_the_firmware_reports_whole_units() -> None:
    rounded, fine = (controller_of(left_radius=0.0981, firmware_units=units) for units in (True, False))
    for controller in (rounded, fine):
        roll(controller, 123_456, 234_567)
    pose, twist = rounded.odometry, rounded.mean_twist(1.0)
    for value, unit in [
        (pose.x, MILLIMETRE),
        (pose.y, MILLIMETRE),
        (pose.theta, ANGLE_UNIT),
        (twist.linear - twist.angular * TRACK / 2, 1e-3),
    ]:
        assert value / unit == pytest.approx(round(value / unit), abs=1e-6)
    assert 0.0 < fine.odometry.distance(pose) < MILLIMETRE


def test_noise_of_the_encoders_does_not_add_up() -> None:
    rng, controller = np.random.default_rng(0), controller_of(encoder_noise=20.0, firmware_units=False)
    ways = []
    for _ in range(2000):
        controller.noise[:2] = rng.standard_normal(2)
        roll(controller, 1000, 1000)
        ways.append(controller.odometry.x * TICKS_PER_METRE)
    assert np.std(ways) == pytest.approx(20.0 / sqrt(2.0), rel=0.1)
    assert abs(np.mean(ways) - 1000.0) < 2.0


def test_mass_and_inertia_of_the_urdf_fit_the_shapes() -> None:
    links = {link.get("name"): link for link in ElementTree.parse(asset("urdf/p3dx.urdf")).findall("link")}

    def numbers(link: str, path: str) -> list[float]:
        return [float(v) for v in links[link].find(path).attrib.values() for v in v.split()]

    def inertia(link: str) -> list[float]:
        found = links[link].find("inertial/inertia").attrib
        return [float(found[axis]) for axis in ("ixx", "iyy", "izz")]

    mass = {link: numbers(link, "inertial/mass")[0] for link in links}
    x, y, z = 0.455, 0.381, 0.237
    box = [mass["base_link"] / 12.0 * (a * a + b * b) for a, b in ((y, z), (x, z), (x, y))]
    r, h = WHEEL_RADIUS, 0.037
    wheel = [mass["left_wheel"] * value for value in ((3 * r * r + h * h) / 12, r * r / 2, (3 * r * r + h * h) / 12)]
    assert sum(mass.values()) == pytest.approx(9.0)
    assert inertia("base_link") == pytest.approx(box, rel=1e-3)
    assert inertia("left_wheel") == inertia("right_wheel") == pytest.approx(wheel, rel=2e-3)
    assert numbers("left_wheel", "collision/geometry/sphere") == [WHEEL_RADIUS]


def test_commands_are_clipped_to_the_limits() -> None:
    base = Rig(limits=Limits(linear=0.7, angular=1.5)).controller
    assert base.command(Twist2D(0.3, -0.4)) == Twist2D(0.3, -0.4)
    assert base.command(Twist2D(5.0, -9.0)) == Twist2D(0.7, -1.5)
    assert base.command(Twist2D(-5.0, 9.0)) == Twist2D(-0.7, 1.5)


@pytest.mark.parametrize("twist", [Twist2D(float("nan"), 0.0), Twist2D(0.0, float("inf"))])
def test_a_command_must_be_finite(twist: Any) -> None:
    with pytest.raises(RobotError, match="finite"):
        Rig().controller.command(twist)


def test_speed_follows_the_ramps() -> None:
    rig = Rig(limits=Limits())
    rig.go(0.6, 0.0, 1.0)
    assert rig.controller.setpoint.linear == pytest.approx(0.3)
    assert rig.base.pose.x == pytest.approx(0.3 / 2, abs=2e-3)
    rig.go(0.6, 0.0, 2.0)
    before = rig.base.pose.x
    rig.go(0.0, 0.0, 2.0)
    assert rig.base.pose.x - before == pytest.approx(0.6**2 / 2 / 0.6, abs=2e-3)
    rig.go(0.0, 5.0, 1.0)
    assert rig.turned == pytest.approx(1.74 / 2, rel=0.01)


def test_a_reversal_decelerates_to_zero_first() -> None:
    speeds, speed = [], 0.3
    while speed != -0.3:
        speed = ramped(speed, -0.3, rise=0.1, fall=0.2)
        speeds.append(speed)
    assert speeds == pytest.approx([0.1, 0.0, -0.1, -0.2, -0.3])


def test_the_watchdog_stops_the_robot_after_two_seconds() -> None:
    rig = Rig()
    rig.controller.command(Twist2D(0.5, 0.0))
    for _ in range(2 * RATE):
        rig.step()
    assert rig.controller.setpoint.linear == 0.5
    rig.step()
    assert rig.controller.setpoint.linear < 0.5
    for _ in range(RATE):
        rig.step()
    assert rig.controller.setpoint == Twist2D()
    stopped = rig.base.pose
    for _ in range(RATE):
        rig.step()
    assert rig.base.pose.distance(stopped) < 1e-4


def test_encoders_count_whole_ticks_of_the_real_wheels() -> None:
    rig = Rig()
    rig.go(0.5, 0.0, 2.0)
    left, _ = rig.controller.ticks
    assert left == pytest.approx(rig.base.pose.x * TICKS_PER_METRE, rel=1e-3)
    assert 124_800 < TICKS_PER_METRE < 128_000
    assert isinstance(left, int)


def test_the_odometry_twist_is_the_mean_since_last_read() -> None:
    controller = controller_of(firmware_units=False)
    roll(controller, round(0.1 * TICKS_PER_METRE), round(0.2 * TICKS_PER_METRE))
    twist = controller.mean_twist(0.5)
    assert twist.linear == pytest.approx(0.3, rel=1e-4)
    assert twist.angular == pytest.approx(0.2 / TRACK, rel=1e-4)
    assert controller.mean_twist(1.0) == Twist2D()


@pytest.mark.parametrize("parts", [1, 50])
def test_travel_noise_grows_with_the_root_of_the_distance(parts: int) -> None:
    metres, noise = 4.0, 0.01
    rng, controller = np.random.default_rng(1), controller_of(travel_noise=noise, firmware_units=False)
    step = round(metres * TICKS_PER_METRE / parts)
    turns = []
    for _ in range(600):
        controller.restart()
        for part in range(1, parts + 1):
            controller.noise[2:] = rng.standard_normal(2)
            roll(controller, step * part, step * part)
        turns.append(controller.odometry.theta * TRACK)
    assert np.std(turns) == pytest.approx(noise * sqrt(metres) * sqrt(2.0), rel=0.1)
    assert abs(np.mean(turns)) < 4 * noise * sqrt(metres) * sqrt(2.0) / sqrt(600)
