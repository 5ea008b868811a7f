"""ir-sim, another planar robot simulator, in the same world with the same number of beams, as a reference for speed."""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import yaml

from slam.named_code import import_optional
from slam.scenario.schema import Scenario


class PlanarPeer:
    """One robot in ir-sim with the interface of an environment."""

    def __init__(self, scenario: Scenario) -> None:
        irsim = import_optional("irsim", "bench")
        with TemporaryDirectory(prefix="hopslam-") as folder:
            path = Path(folder) / "world.yaml"
            path.write_text(yaml.safe_dump(_world(scenario)), encoding="utf-8")
            self._env = irsim.make(str(path), headless=True, log_level="ERROR", seed=0)

    def reset(self, seed: int) -> None:
        """Put the robot back to its start."""
        self._env.reset()

    def step(self, action: np.ndarray[Any, np.dtype[np.float32]]) -> Any:
        """Drive for a scan at these speeds, v and omega, and return the ranges."""
        self._env.step(action.reshape(2, 1))
        return self._env.get_lidar_scan()["ranges"]

    def close(self) -> None:
        """Close the world."""
        self._env.end()


def _world(scenario: Scenario) -> dict[str, Any]:
    """Describe a scenario for ir-sim: the walls, a round robot, and a lidar with Gaussian noise of 1 cm."""
    outlines = scenario.world.outlines(scenario.lidar.height)
    low, high = np.min([o.min(axis=0) for o in outlines], axis=0), np.max([o.max(axis=0) for o in outlines], axis=0)
    width, height = (high - low + 2.0).tolist()
    lidar = scenario.lidar.description.lidar
    sensor = {
        "name": "lidar2d", "number": lidar.beams, "angle_range": lidar.angle_max - lidar.angle_min,
        "range_min": lidar.range_min, "range_max": lidar.range_max, "noise": True, "std": 0.01,
    }  # fmt: skip
    robot = {
        "kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.25},
        "state": scenario.robot.start.pose.as_array().tolist(), "sensors": [sensor],
    }  # fmt: skip
    world = {"width": width, "height": height, "offset": (low - 1.0).tolist(), "step_time": lidar.scan_time}
    walls = [{"shape": {"name": "polygon", "vertices": o.tolist()}, "state": [0.0, 0.0, 0.0]} for o in outlines]
    return {"world": world, "robot": [robot], "obstacle": walls}
