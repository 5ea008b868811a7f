"""Drives a robot around squares, and fits its wheels to them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from slam.errors import ScenarioError
from slam.line_slam import LineSlam
from slam.pose import FloatArray, Pose2D
from slam.robot import Observation
from slam.run.backends import make_robot
from slam.run.calibration.square import Square, SquareDrive
from slam.run.calibration.wheel_fit import Leg, WheelFit, corrected, displacement, fit_errors, fit_wheels
from slam.scenario.hardware_config import FIRMWARE_TRACK
from slam.scenario.schema import Scenario

_LONG_ENOUGH = 1e5
"""Duration, seconds: the drive ends after the squares, and not after the scenario's duration."""
_LEGS_PER_LAP = 8


@dataclass(frozen=True, slots=True, eq=False)
class Calibration:
    """The drive, the result of the fit, and the track that the odometry assumed, metres."""

    legs: Sequence[Leg]
    fit: WheelFit
    track: float
    against: str
    """Reference of the fit: ``the truth`` or ``SLAM``."""

    @property
    def errors(self) -> WheelFit:
        """Standard errors of the fit."""
        return fit_errors(self._squares, self.track)

    @property
    def _squares(self) -> list[Sequence[Leg]]:
        return [self.legs[at : at + _LEGS_PER_LAP] for at in range(0, len(self.legs), _LEGS_PER_LAP)]

    @property
    def laps(self) -> list[Leg]:
        """Whole squares, first those to the right, then those to the left."""
        return [_joined(square) for square in self._squares]

    def worst_closing_error(self, fit: WheelFit) -> float:
        """UMBmark's E_max,syst, metres: the distance by which the odometry with this fit misses the end of a square.

        It is the mean over the squares in one direction, for the direction with the larger mean.
        """
        misses = [displacement(corrected(lap.odometry, self.track, fit)) - displacement(lap.truth) for lap in self.laps]
        both = np.array(misses).reshape(2, -1, 2).mean(axis=1)
        return float(np.hypot(both[:, 0], both[:, 1]).max())


def calibrate(
    scenario: Scenario, square: Square, backend: str, on_leg: Callable[[int], object], **options: bool
) -> Calibration:
    """Drive, and fit: against the true pose if the back end knows it, else against SLAM.

    ``on_leg`` is called after every leg. ``options`` are the back end's own.
    """
    scenario = scenario.model_copy(update={"duration": _LONG_ENOUGH})
    slam = LineSlam(scenario.slam, scenario.lidar.mount.pose, scenario.robot.start.pose, scenario.seed)
    known = []

    def locate(observation: Observation) -> Pose2D:
        known.append(observation.T_map_base is not None)
        return observation.T_map_base or slam.update(observation.scan, observation.odometry).T_map_base

    legs = []
    with make_robot(backend, scenario, seed=scenario.seed, **options) as robot:
        for leg in SquareDrive(robot, locate).drive(square):
            legs.append(leg)
            on_leg(len(legs))
    track = believed_track(scenario, backend)
    return Calibration(legs, fit_wheels(legs, track), track, "the truth" if known[-1] else "SLAM")


def require_backend(backend: str) -> None:
    """Raise ScenarioError for a back end without wheels of its own."""
    if backend not in ("sim", "hardware"):
        raise ScenarioError(f"--backend {backend}: only sim and hardware have wheels to calibrate; choose one of them")


def believed_track(scenario: Scenario, backend: str) -> float:
    """Return the track that the odometry of this back end assumes, metres."""
    return scenario.robot.odometry.track if backend == "sim" else FIRMWARE_TRACK * scenario.hardware.track_scale


def wheel_settings(scenario: Scenario, backend: str, fit: WheelFit) -> dict[str, dict[str, object]]:
    """Return the keys of a scenario that correct the odometry.

    In the simulator they are assumptions of the firmware; on the robot, whose firmware cannot change, they are
    corrections of its reports in the driver.
    """
    if backend == "sim":
        wheels = scenario.robot.odometry
        believed = {
            "left_radius": wheels.left_radius * fit.left,
            "right_radius": wheels.right_radius * fit.right,
            "track": wheels.track * fit.track,
        }
        return {"robot": {"odometry": {key: round(value, 7) for key, value in believed.items()}}}
    config = scenario.hardware
    scales = {
        "left_scale": config.left_scale * fit.left,
        "right_scale": config.right_scale * fit.right,
        "track_scale": config.track_scale * fit.track,
    }
    return {"hardware": {key: round(value, 6) for key, value in scales.items()}}


def _joined(legs: Sequence[Leg]) -> Leg:
    """Join legs into one: each begins with the last pose of the one before."""

    def whole(parts: list[FloatArray]) -> FloatArray:
        return np.concatenate([parts[0], *(part[1:] for part in parts[1:])])

    return Leg(whole([leg.odometry for leg in legs]), whole([leg.truth for leg in legs]))
