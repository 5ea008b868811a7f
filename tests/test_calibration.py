"""Calibration of the wheels: known errors are estimated; squares are driven and recorded."""

import re
import sys
from math import pi
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hardware.base_odometry import WheelScales
from slam.cli.main import main
from slam.errors import InputError
from slam.odometry import Twist2D
from slam.pose import FloatArray
from slam.run.calibration.calibrate import calibrate
from slam.run.calibration.report import extends_value, write_wheels
from slam.run.calibration.square import Square
from slam.run.calibration.wheel_fit import (
    Leg,
    WheelFit,
    corrected,
    dead_reckoned,
    fit_errors,
    fit_wheels,
    wheel_travels,
)
from slam.scenario.file import load_scenario

TRACK = 0.33
factors = st.floats(0.97, 1.03)
fits = st.builds(WheelFit, left=factors, right=factors, track=factors)


def square(turn: float, rng: np.random.Generator) -> list[FloatArray]:
    """The odometry (K, 3) of each side and each turn of a square, in steps of random length."""
    legs, start = [], np.zeros(3)
    for _ in range(4):
        for displacement, angle in ((2.0, rng.normal(0.0, 0.05)), (rng.normal(0.0, 0.01), turn)):
            shares = rng.dirichlet(np.ones(9))
            rim = angle * TRACK / 2.0
            legs.append(dead_reckoned(start, (displacement - rim) * shares, (displacement + rim) * shares, TRACK))
            start = legs[-1][-1]
    return legs


@settings(max_examples=30)
@given(fits, st.integers(0, 2**32))
def test_known_wheel_errors_are_estimated(fit: WheelFit, seed: int) -> None:
    rng = np.random.default_rng(seed)
    legs = []
    for odometry in [*square(-pi / 2, rng), *square(pi / 2, rng)]:
        begin = np.array([*rng.normal(0.0, 3.0, 2), rng.uniform(-pi, pi)])
        ways = wheel_travels(odometry, TRACK)
        truth = dead_reckoned(begin, fit.left * ways[0], fit.right * ways[1], fit.track * TRACK)
        truth[:, 2] = (truth[:, 2] + pi) % (2 * pi) - pi
        legs.append(Leg(odometry, truth))
    found = fit_wheels(legs, TRACK)
    assert (found.left, found.right, found.track) == pytest.approx((fit.left, fit.right, fit.track), abs=1e-9)


@given(fits, st.integers(0, 2**32))
def test_exact_odometry_needs_no_correction(fit: WheelFit, seed: int) -> None:
    odometry = np.concatenate(square(pi / 2, np.random.default_rng(seed)))
    np.testing.assert_allclose(corrected(odometry, TRACK, WheelFit())[:, :2], odometry[:, :2], atol=1e-9)


@given(fits, st.floats(-1, 1), st.floats(-2, 2))
def test_the_driver_applies_the_fitted_correction(fit: WheelFit, linear: float, angular: float) -> None:
    rim = angular * TRACK / 2.0
    begin, left, right = np.zeros(3), np.array([linear - rim]), np.array([linear + rim])
    expected = dead_reckoned(begin, fit.left * left, fit.right * right, fit.track * TRACK)[-1]
    scales = WheelScales(TRACK / 2.0, fit.left, fit.right, fit.track)
    corrected_twist = scales.corrected(Twist2D(linear, angular))
    assert corrected_twist.angular == pytest.approx(expected[2], abs=1e-12)
    assert corrected_twist.linear == pytest.approx((fit.left * left[0] + fit.right * right[0]) / 2.0)


def test_standard_errors_show_the_spread_of_the_squares() -> None:
    rng = np.random.default_rng(1)
    squares = [[Leg(legs, legs) for legs in square(turn, rng)] for turn in (-pi / 2, pi / 2, pi / 2)]
    errors = fit_errors(squares, TRACK)
    assert (errors.left, errors.right, errors.track) == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)
    wider = [Leg(leg.odometry, leg.odometry * [1.01, 1.01, 1.0]) for leg in squares[0]]
    errors = fit_errors([wider, *squares[1:]], TRACK)
    assert (errors.left, errors.right) == pytest.approx((0.01 / 3, 0.01 / 3), rel=0.3)


def test_straight_paths_alone_are_refused() -> None:
    straight = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
    with pytest.raises(InputError, match="straight legs and turns"):
        fit_wheels([Leg(straight, straight)] * 8, TRACK)


def test_the_simulated_wheels_are_estimated(tmp_path: Path) -> None:
    exact = ["robot.odometry.travel_noise=0", "robot.odometry.firmware_units=false", "lidar.caster=exact"]
    scenario = load_scenario("umbmark_room", exact)
    found = calibrate(scenario, Square(size=1.0, laps=1, speed=0.5, turn_speed=1.0), "sim", lambda _: None)
    assert found.worst_closing_error(found.fit) < 0.1 * found.worst_closing_error(WheelFit())
    write_wheels(tmp_path / "wheels.yaml", extends_value("umbmark_room"), scenario, "sim", found)
    wheels = load_scenario(tmp_path / "wheels.yaml").robot.odometry
    assert wheels.left_radius == pytest.approx(0.0975, abs=0.02 * 0.0005)
    assert wheels.right_radius == pytest.approx(0.0975, abs=0.02 * 0.0008)
    assert wheels.track == pytest.approx(0.330, abs=0.02 * 0.004)


def test_the_command_writes_a_scenario_a_picture_and_a_table(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "wheels.yaml"
    words = ["calibrate", "square", "--size", "0.5", "--laps", "1", "--onto", "corridor", "--out", str(out)]
    monkeypatch.setattr(sys, "argv", ["hopslam", *words, "--speed", "0.5"])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 0
    assert out.read_text().startswith("# Two standard errors")
    assert load_scenario(out).route == load_scenario("corridor").route
    assert out.with_suffix(".png").stat().st_size > 10_000
    assert re.search(
        r"^ *left wheel, true per reported distance +\d\.\d+ \+- \d\.\d+ *$", capsys.readouterr().out, re.M
    )


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["--backend", "replay"], "choose one of them"),
        (["--yes"], "add --backend hardware"),
        (["--onto", "corridr"], "did you mean corridor"),
        (["--out", "/nowhere/wheels.yaml"], "cannot be written there"),
    ],
)
def test_unsuitable_runs_are_refused(
    words: list[str], complaint: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["hopslam", "calibrate", "square", *words])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    assert complaint in capsys.readouterr().err
