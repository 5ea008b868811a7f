"""Draw docs/noise.png and docs/env.png by the simulated robot: ``python docs/draw_robot.py``, or ``make pictures``."""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

import gymnasium
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import PolyCollection
from PIL import Image

from sim.robot import SimRobot
from slam.pose import FloatArray
from slam.scenario.file import load_scenario
from slam.scenario.schema import Scenario

DOCS: Final = Path(__file__).parent
NOISES: Final = ("none", "datasheet", "paper", "realistic")
ROOM: Final = """
world:
  walls:
    - {points: [[-1.55, -1.5], [3.2, -1.5], [3.2, 1.5], [-1.55, 1.5]], closed: true, thickness: 0.1}
  boxes: [{center: [1.1, 0.8], size: [0.3, 0.4, 0.8], yaw: 0.4}]
  tables: [{center: [0.0, -1.0], size: [1.0, 0.5, 0.7]}]
  cylinders: [{center: [1.6, -0.6], radius: 0.15, height: 0.8}]
lidar: {reflectivity: 0.3}
"""


def scan_points(scenario: Scenario) -> FloatArray:
    """Take the first scan of a robot that stands; end points (N, 2), map frame, metres."""
    with SimRobot(scenario) as robot:
        observation = robot.observe()
    assert observation is not None
    return (scenario.robot.start.pose @ scenario.lidar.mount.pose).transform(observation.scan.points())


def draw_noises(path: Path) -> None:
    """Draw one scan of the same room under each noise."""
    figure, grid = plt.subplots(2, 2, figsize=(8.0, 5.6), sharex=True, sharey=True, layout="constrained")
    with TemporaryDirectory() as folder:
        room = Path(folder) / "room.yaml"
        room.write_text(ROOM)
        for axes, noise in zip(grid.flat, NOISES, strict=True):
            scenario = load_scenario(room, [f"lidar.noise={noise}"])
            cut = [p for p in scenario.world.prisms() if p.bottom <= scenario.lidar.height <= p.top]
            axes.add_collection(PolyCollection([p.footprint for p in cut], facecolors="0.85"))
            axes.plot(*scan_points(scenario).T, ".", color="tab:red", markersize=2)
            axes.plot(scenario.robot.start.x, scenario.robot.start.y, "k>", markersize=4)
            axes.set(title=f"noise: {noise}", aspect="equal")
            axes.label_outer()
    figure.supxlabel("x [m]", fontsize="medium")
    figure.supylabel("y [m]", fontsize="medium")
    figure.savefig(path, dpi=150)


def draw_environment(path: Path) -> None:
    """Draw what the environment renders after some steps towards its way-points in an office with people."""
    env = gymnasium.make(
        "sim:hopslam/RandomOffice-v0",
        settings="generate.people=3",
        render_mode="rgb_array",
        observe=("goal", "slam_pose"),
        goal_as="xy",
    )
    observation, _ = env.reset(seed=7)
    for _ in range(220):
        x, y = observation["goal"]
        turn = float(np.arctan2(y, x))
        observation, *_ = env.step(
            np.array([0.4 if abs(turn) < 0.3 else 0.0, np.clip(2.0 * turn, -0.8, 0.8)], np.float32)
        )
    Image.fromarray(np.asarray(env.render())).save(path)
    env.close()


if __name__ == "__main__":
    draw_noises(DOCS / "noise.png")
    draw_environment(DOCS / "env.png")
