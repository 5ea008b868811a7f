"""Values that a viewer shows: the scene once, a frame for each scan with its curves, and events."""

from collections.abc import Callable
from dataclasses import dataclass
from math import degrees, nan, sqrt
from typing import Final, Literal, NamedTuple

import numpy as np

from slam.pose import FloatArray, Pose2D
from slam.run.estimator import Estimator
from slam.run.viewer.loop_events import LoopsShown
from slam.run.viewer.palette import Colour
from slam.scenario.schema import Scenario

Level = Literal["INFO", "WARN", "ERROR"]
_ORIGIN = Pose2D()


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """One scan, the poses at it and the results of the method; map frame, metres, radians, seconds."""

    index: int
    stamp: float
    slam: Pose2D | None
    """``T_map_base`` as estimated; None without an estimate."""
    odometry: Pose2D
    """``T_map_base`` by dead reckoning."""
    truth: Pose2D | None
    """The true ``T_map_base``, if known."""
    points: FloatArray
    """(N, 2): end points of the beams with an echo."""
    point_colours: Colour
    """(N,): colour of the segment that each point belongs to."""
    ends: FloatArray
    """(M, 2, 2): segments, [segment, start or end, x or y]."""
    end_colours: Colour
    """(M,): colours of the segments."""
    covariance: FloatArray | None = None
    """(3, 3): covariance of x, y, theta."""
    unconstrained: FloatArray | None = None
    """(K, 3): unconstrained directions, see Match."""
    iterations: int = 0
    extraction_time: float = 0.0
    total_time: float = 0.0
    command: tuple[float, float] = (0.0, 0.0)
    """Applied velocity, m/s and rad/s."""
    battery: float = nan
    """Battery voltage; nan if unknown."""
    sonar: FloatArray | None = None
    """(K, 2): echoes of the sonar rings; None without a ring."""
    loops: LoopsShown | None = None
    """Path and loops, if they changed at this scan."""
    jumped: bool = False
    """True if the estimate jumped: no stroke leads here."""

    @property
    def robot(self) -> Pose2D:
        """Pose at which the robot is drawn: the estimate, or else the true pose, or else dead reckoning."""
        return self.slam or self.truth or self.odometry


@dataclass(frozen=True, slots=True)
class Event:
    """One line of the log, at one scan."""

    scan: int
    stamp: float
    level: Level
    text: str


class Plot(NamedTuple):
    """One view of curves; ``values`` gives one number per curve, nan if there is none."""

    title: str
    curves: tuple[str, ...]
    values: Callable[[Frame], tuple[float, ...]]


def _position(frame: Frame) -> tuple[float, ...]:
    error = float("nan") if frame.truth is None else 100 * frame.truth.distance(frame.robot)
    C = frame.covariance
    return error, float("nan") if C is None else 100 * sqrt(max(C[0, 0] + C[1, 1], 0.0))


def _heading(frame: Frame) -> tuple[float, ...]:
    error = float("nan") if frame.truth is None else degrees(frame.truth.between(frame.robot).theta)
    C = frame.covariance
    return error, float("nan") if C is None else degrees(sqrt(max(C[2, 2], 0.0)))


PLOTS: Final = {
    "position": Plot("position, cm", ("error", "sigma"), _position),
    "heading": Plot("heading, degrees", ("error", "sigma"), _heading),
    "iterations": Plot("iterations", ("iterations",), lambda frame: (frame.iterations,)),
    "time": Plot(
        "time a scan, ms", ("all", "lines"), lambda frame: (1e3 * frame.total_time, 1e3 * frame.extraction_time)
    ),
    "command": Plot("command, m/s and rad/s", ("v", "omega"), lambda frame: frame.command),
    "battery": Plot("battery, V", ("volts",), lambda frame: (frame.battery,)),
}


def plots(battery: bool) -> tuple[str, ...]:
    """Return the names of the curves, for a robot that reports its battery or not."""
    return tuple(name for name in PLOTS if battery or name != "battery")


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """Facts about a run that are known before its first scan; map frame, metres."""

    T_base_laser: Pose2D
    T_map_odom: Pose2D = _ORIGIN
    """Start of dead reckoning."""
    slam: Estimator | None = None
    """Estimator whose map is shown as it grows."""
    deskew: bool = False
    """True if the method deskews the scans."""
    outlines: tuple[FloatArray, ...] = ()
    """Outlines of the true world that the lidar can see: closed polygons (V, 2)."""
    route: FloatArray | None = None
    """Way-points (W, 2), including the start."""
    around: FloatArray | None = None
    """Additional points (N, 2) that the first view should show."""
    plots: tuple[str, ...] = plots(battery=False)
    """Names of the curves that are shown."""


def planned_route(scenario: Scenario) -> FloatArray | None:
    """Return start and way-points of a scenario (W, 2), metres, map frame; None without way-points."""
    start, waypoints = scenario.robot.start.pose, scenario.route.waypoints
    return np.array([(start.x, start.y), *waypoints]) if waypoints else None
