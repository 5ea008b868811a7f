"""A cable is unplugged and plugged in during a run: the estimate recovers and no recorded scan is lost."""

import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from hardware.emulator.emulator import Emulator
from hardware.emulator.p3dx import FACTORY_CONFIG
from hardware.emulator.pty_port import PtyPort
from sim.plant import plan_plant
from slam.odometry import Twist2D
from slam.pose import Pose2D
from slam.run.experiment_setup import scenario_experiment
from slam.run.results.run_record import RunRecord
from slam.scan import LaserScan
from slam.scenario.file import load_scenario

OUT, STOP, END = 12, 24, 32
"""Scans after which the cable is pulled, the robot stops, and the run ends."""


@dataclass
class Course:
    """A pilot that drives straight on, and pulls a cable at scan OUT."""

    pull: Callable[[], object]
    progress: float = 0.0
    scans: int = 0
    estimate: Pose2D = Pose2D()  # noqa: RUF009  # frozen

    def command(self, T_map_base: Pose2D, scan: LaserScan) -> Twist2D | None:
        self.scans, self.estimate = self.scans + 1, T_map_base
        if self.scans == OUT:
            self.pull()
        return None if self.scans == END else Twist2D(0.4 if self.scans < STOP else 0.0, 0.0)


@pytest.mark.parametrize("device", ["robot", "lidar"])
def test_a_cable_unplugged_for_a_while_is_survived(device: str, tmp_path: Path) -> None:
    ports = PtyPort(tmp_path / "p3dx"), PtyPort(tmp_path / "urg04lx")
    plant = plan_plant(load_scenario("corridor"))
    with Emulator(plant, *ports, paced=False, robot_config=replace(FACTORY_CONFIG, watchdog=0.8)) as emulator:

        def pull() -> None:
            connected = getattr(emulator, device)
            emulator.do(connected.unplug)
            threading.Timer(1.2, emulator.do, [connected.port.open]).start()

        experiment = scenario_experiment(load_scenario("corridor", emulator.port_settings), "hardware", yes=True)
        course = Course(pull)
        outcome = replace(experiment, pilot=course).run(tmp_path / "run", pictures=False)
        assert course.estimate.distance(emulator.truth[1]) < 0.03
    assert outcome.ending == "arrived"
    record = RunRecord.open(tmp_path / "run")
    assert record.metrics is not None
    assert len(record.traces.stamps) == END
    assert len(list(record.observations())) == END
