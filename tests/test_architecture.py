"""The pictures of docs/architecture.md match the code, and a run calls the functions that they show."""

import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import FrameType, FunctionType, ModuleType
from typing import Any

import pytest

from hardware.emulator.emulator import Emulator
from sim.robot import SimRobot
from slam.run.backends import make_robot
from slam.run.experiment_setup import scenario_experiment
from slam.scenario.file import load_scenario
from tests.rooms import room_plant

DOCS = Path(__file__).parents[1] / "docs"


@pytest.fixture(scope="module")
def drawing() -> ModuleType:
    spec = spec_from_file_location("draw_architecture", DOCS / "draw_architecture.py")
    assert spec is not None
    assert spec.loader is not None
    spec.loader.exec_module(module := module_from_spec(spec))
    return module


def test_the_pictures_match_the_code(drawing: ModuleType) -> None:
    for file, draw in drawing.PICTURES.items():
        assert (DOCS / file).read_text() == draw(), "run python docs/draw_architecture.py"


def run_simulated(folder: Path) -> None:
    scenario_experiment(load_scenario("corridor", ["duration=0.4"])).run(folder / "run")


def set_the_travel_noise(folder: Path) -> None:
    SimRobot(load_scenario("corridor", ["physics.engine=bullet", "robot.odometry.travel_noise=0.01"])).observe()


def listen_to_a_lidar(folder: Path) -> None:
    with Emulator(room_plant((-2.0, 3.5), (-2.0, 2.0), 0.16), paced=False) as emulator:
        scenario = load_scenario("corridor", [*emulator.port_settings, "duration=1"])
        with make_robot("hardware", scenario, yes=True) as robot:
            robot.observe()
            robot.observe()


@pytest.mark.parametrize(
    ("way", "go"), [("scan", run_simulated), ("key", set_the_travel_noise), ("byte", listen_to_a_lidar)]
)
def test_a_run_calls_the_functions_of_the_picture(
    way: str, go: Callable[[Path], None], drawing: ModuleType, tmp_path: Path
) -> None:
    stations = {code_of(drawing.station(name)): name for name in drawing.WAYS[way]}
    with calls(stations) as called:
        go(tmp_path)
    passed = iter(called)
    missed = [name for name in drawing.WAYS[way] if name not in passed]  # ``in`` uses up the iterator: order counts
    assert missed == []


def code_of(station: type | FunctionType) -> Any:
    """Return the code that runs when a station is called; of a class, that of its ``__init__``."""
    function: Any = vars(station)["__init__"] if isinstance(station, type) else station
    return function.__code__


@contextmanager
def calls(stations: dict[Any, str]) -> Iterator[list[str]]:
    """Yield the list of the stations that are called, in their order, in all threads."""
    called: list[str] = []

    def profile(frame: FrameType, event: str, _: object) -> None:
        if event == "call" and frame.f_code in stations:
            called.append(stations[frame.f_code])

    threading.setprofile(profile)
    sys.setprofile(profile)
    try:
        yield called
    finally:
        sys.setprofile(None)
        threading.setprofile(None)
