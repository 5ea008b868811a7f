"""Fig. 3: the scan from (1 m, 1 m, 20 deg) on the plan of Fig. 1, taken by the simulated sensor of Table 1."""

from dataclasses import dataclass
from math import degrees, pi, radians
from pathlib import Path
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from slam.bench.log_score import distances_to_segments
from slam.errors import RobotError
from slam.lines.extraction import extract_segments
from slam.lines.segments import Segments
from slam.pose import FloatArray, Pose2D
from slam.run.backends import make_robot
from slam.run.pictures.figure_style import PAPER, save_figure
from slam.scan import LaserScan
from slam.scenario.file import load_scenario

SCENARIO: Final = "paper_simulation"
"""Scenario whose plan has the shape of Fig. 1, for which the paper gives no coordinates."""
X_K, Y_K, PHI_K = 1.0, 1.0, radians(20.0)
"""The pose in section 2, metres and radians; phi is 0 if the sensor's y axis is parallel to the map's."""


@dataclass(frozen=True, slots=True, eq=False)
class Fig3:
    """The scan, and its segments by the paper's method."""

    T_map_laser: Pose2D
    """True pose of the sensor. Its x axis points ahead; in the paper the y axis does: theta = phi_k + 90 deg."""
    scan: LaserScan
    segments: Segments
    """Segments in the sensor frame."""
    outlines: tuple[FloatArray, ...]
    """Outlines (N, 2) of the walls, map frame, metres."""

    @property
    def phi(self) -> float:
        """The paper's phi_k, radians."""
        return self.T_map_laser.theta - pi / 2.0

    @property
    def point_errors(self) -> FloatArray:
        """Distance of every point of the scan from the nearest wall, metres, (M,)."""
        return self._off_walls(self.scan.points())

    @property
    def segment_errors(self) -> FloatArray:
        """Distance of the middle of every segment's line from the nearest wall, metres, (S,)."""
        middles = (self.segments.start + self.segments.end) / 2.0
        off_line = np.sum(self.segments.normals * middles, axis=1) - self.segments.rho
        return self._off_walls(middles - off_line[:, None] * self.segments.normals)

    def _off_walls(self, points: FloatArray) -> FloatArray:
        ends = [np.roll(outline, -1, axis=0) for outline in self.outlines]
        start, end = np.concatenate(self.outlines), np.concatenate(ends)
        return distances_to_segments(self.T_map_laser.transform(points), start, end)


def measure(noise: str = "paper", seed: int = 0) -> Fig3:
    """Take the scan, with this ``lidar.noise``, and extract its segments with the settings of the scenario."""
    start = (f"robot.start.x={X_K}", f"robot.start.y={Y_K}", f"robot.start.theta={PHI_K + pi / 2.0}")
    scenario = load_scenario(SCENARIO, [*start, f"lidar.noise={noise}"])
    with make_robot("sim", scenario, seed=seed) as robot:
        observation = robot.observe()
    if observation is None or observation.T_map_base is None:
        raise RobotError("the simulated robot gave no scan with its true pose")
    return Fig3(
        T_map_laser=observation.T_map_base @ scenario.lidar.mount.pose,
        scan=observation.scan,
        segments=extract_segments(observation.scan, scenario.slam.lines),
        outlines=tuple(scenario.world.outlines(scenario.lidar.height)),
    )


def draw(result: Fig3, path: Path) -> None:
    """Draw the sensor on the plan, and the scan with its segments in the sensor frame, y up."""
    figure = Figure(figsize=(11, 5.5), dpi=110, layout="constrained")
    plan, scan = figure.subplots(1, 2)
    _draw_plan(plan, result)
    scan.plot(*upright(result.scan.points()).T, ".", color="0.5", markersize=5)
    draw_segments(scan, result.segments, "black", (PAPER.slam, PAPER.odometry), 1.2)
    scan.plot(0.0, 0.0, "+", color=PAPER.accent, markersize=14)
    scan.set(xlabel="x of the paper, -y here [m]", ylabel="y of the paper, x here [m]", aspect="equal")
    scan.set_title(f"(b) the scan: {len(result.scan.points())} points, {len(result.segments)} segments")
    save_figure(figure, path)


def _draw_plan(axes: Axes, result: Fig3) -> None:
    axes.add_collection(PolyCollection(result.outlines, facecolors="0.75", edgecolors="0.3", linewidths=0.6))
    axes.plot(*result.T_map_laser.transform(result.scan.points()).T, ".", color=PAPER.odometry, markersize=3)
    pose = result.T_map_laser
    axes.plot(pose.x, pose.y, "+", color=PAPER.accent, markersize=14)
    ahead = tuple((pose @ Pose2D(0.8)).translation.tolist())
    axes.annotate("", ahead, (pose.x, pose.y), arrowprops={"arrowstyle": "->", "color": PAPER.accent})
    axes.set(xlabel="X [m]", ylabel="Y [m]", aspect="equal", xlim=(-3.3, 5.3), ylim=(-0.3, 6.3))
    axes.set_title(f"(a) X = {pose.x:.2f} m, Y = {pose.y:.2f} m, phi = {degrees(result.phi):.1f} deg")


def draw_segments(axes: Axes, segments: Segments, colour: str, end_colours: tuple[str, str], width: float) -> None:
    """Draw segments as the paper does: a square at the start, and a circle at the end."""
    for start, end in zip(segments.start, segments.end, strict=True):
        axes.plot(*upright(np.array([start, end])).T, color=colour, linewidth=width)
        axes.plot(*upright(start), "s", color=end_colours[0], markerfacecolor="none", markersize=8)
        axes.plot(*upright(end), "o", color=end_colours[1], markerfacecolor="none", markersize=8)


def upright(points: FloatArray) -> FloatArray:
    """Points (..., 2) in the paper's frame o-xy, whose y axis points ahead."""
    return np.stack([-points[..., 1], points[..., 0]], axis=-1)
