"""Rooms for emulated devices."""

from sim.plant import SimPlant
from slam.scenario.schema import Scenario


def room_scenario(
    x: tuple[float, float], y: tuple[float, float], laser_x: float = 0.0, model: str = "urg04lx"
) -> Scenario:
    """The inside of a box between these coordinates, with the robot at the origin and a lidar without noise."""
    middle, size = ((x[0] + x[1]) / 2.0, (y[0] + y[1]) / 2.0), (x[1] - x[0], y[1] - y[0], 1.0)
    return Scenario.model_validate(
        {
            "name": "room",
            "world": {"boxes": [{"center": middle, "size": size}]},
            "physics": {"engine": "plan"},
            "lidar": {"model": model, "mount": {"x": laser_x}, "noise": "none"},
        }
    )


def room_plant(
    x: tuple[float, float], y: tuple[float, float], laser_x: float = 0.0, model: str = "urg04lx"
) -> SimPlant:
    """A plant in this room."""
    return SimPlant(room_scenario(x, y, laser_x, model))
