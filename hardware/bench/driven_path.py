"""The path of a robot in one run, truth and estimate, and the difference of two paths."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final, Self

import numpy as np

from hardware.emulator.emulator import Emulator
from hardware.robot import HardwareRobot
from slam.pose import FloatArray, Pose2D, path_lengths, stack_poses, wrap_angles
from slam.robot import Robot
from slam.run.step import Step

_MOVES: Final = 0.01
"""Metres from one pose to the next; a robot that moves less is at rest, or turns on the spot."""
_LEG: Final = 1.0
"""Least length of a leg, metres."""
_STEP: Final = 0.005
"""Metres between the compared points of a path."""
_NEW_LEG: Final = 0.5
"""Radians by which a robot turns on the spot between two legs; one that stopped and turned less stays in its leg."""
_TURN: Final = 0.5
"""Metres from the ends of a leg within which the robot may still turn into it, or already into the next."""


@dataclass(frozen=True, slots=True, eq=False)
class DrivenPath:
    """The path of one run, scan by scan; poses are rows x, y, theta of ``T_map_base``, (N, 3)."""

    truth: FloatArray
    estimate: FloatArray

    @property
    def errors(self) -> FloatArray:
        """Distances between estimate and truth, (N,), metres, without alignment, as both begin at the same pose."""
        errors: FloatArray = np.hypot(*(self.estimate - self.truth)[:, :2].T)
        return errors


@dataclass
class PathRecorder:
    """Watcher that keeps estimated and true poses.

    The true pose is that at the stamp of the scan; on emulated devices it is the present one.
    """

    emulator: Emulator | None = None
    stamps: list[float] = field(default_factory=list)
    estimate: list[Pose2D] = field(default_factory=list)
    truth: list[tuple[float, Pose2D]] = field(default_factory=list)

    def on_step(self, step: Step) -> None:
        observation = step.observation
        self.stamps.append(observation.scan.stamp)
        self.estimate.append(step.estimate.T_map_base)
        if self.emulator is not None:
            self.truth.append(self.emulator.truth)
        elif observation.T_map_base is not None:
            self.truth.append((observation.scan.stamp, observation.T_map_base))

    def path(self, robot: Robot) -> DrivenPath:
        """Return the path with the true poses at the scans' stamps, which a real robot counts from its epoch."""
        epoch = (robot.epoch or 0.0) if isinstance(robot, HardwareRobot) else 0.0
        known = np.array([stamp for stamp, _ in self.truth]) - epoch
        x, y, theta = stack_poses([pose for _, pose in self.truth]).T
        truth = [np.interp(self.stamps, known, column) for column in (x, y, np.unwrap(theta))]
        return DrivenPath(np.column_stack(truth), stack_poses(self.estimate))


@dataclass(frozen=True, slots=True)
class PathDifference:
    """Difference of two paths at the same points along the route, whatever the time; turns on the spot are left out.

    The clocks of two runs start at different times; so each point of one path is compared with the nearest point of the
    same leg of the other path.
    """

    length: float
    """Length that was compared, metres."""
    largest: float
    """Largest distance between the points, metres."""
    rms: float
    """Root mean square of the distance between the points, metres."""
    heading: float
    """Largest difference of the headings there, radians, except near the ends of legs."""
    ends: float
    """Largest distance between the ends of the same leg, metres: a robot checks for its arrival once per scan only."""

    @classmethod
    def between(cls, one: FloatArray, other: FloatArray) -> Self:
        """Compare two paths of poses x, y, theta, (N, 3) and (M, 3), with the same number of legs."""
        legs = list(zip(_legs(one), _legs(other), strict=True))
        apart, turned = map(np.concatenate, zip(*(_nearest_offsets(a, b) for a, b in legs), strict=True))
        ends = max(float(np.hypot(*(a[-1] - b[-1])[:2])) for a, b in legs)
        rms = float(np.sqrt(np.mean(apart**2)))
        return cls(len(apart) * _STEP, float(apart.max()), rms, float(np.abs(turned).max()), ends)


def _legs(poses: FloatArray) -> Sequence[FloatArray]:
    """Split a path where the robot turns on the spot, and resample each leg in steps of ``_STEP``."""
    steps = np.hypot(*np.diff(poses[:, :2], axis=0).T)
    ends = np.flatnonzero(np.diff(np.concatenate([[False], steps > _MOVES, [False]]).astype(int))).reshape(-1, 2)
    turns = np.abs(wrap_angles(poses[ends[1:, 0], 2] - poses[ends[:-1, 1], 2]))
    pieces = np.split(ends, np.flatnonzero(turns > _NEW_LEG) + 1)
    spans = [slice(piece[0, 0], piece[-1, 1] + 1) for piece in pieces]
    return [_resampled(poses[span]) for span in spans if steps[span].sum() > _LEG]


def _resampled(poses: FloatArray) -> FloatArray:
    driven = path_lengths(poses)
    at = np.arange(0.0, driven[-1], _STEP)
    columns = (poses[:, 0], poses[:, 1], np.unwrap(poses[:, 2]))
    return np.column_stack([np.interp(at, driven, column) for column in columns])


def _nearest_offsets(one: FloatArray, other: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return metres and radians from each point of one leg to the nearest point of the other leg.

    Points whose nearest point is an end of the other leg are left out. Radians are 0 near the ends.
    """
    nearest = np.array([np.argmin(np.sum((other[:, :2] - place) ** 2, axis=1)) for place in one[:, :2]])
    inside = (nearest > 0) & (nearest < len(other) - 1)
    difference = (one - other[nearest])[inside]
    turned = wrap_angles(difference[:, 2])
    near = round(_TURN / _STEP)
    turned[:near] = turned[-near:] = 0.0
    return np.hypot(difference[:, 0], difference[:, 1]), turned
