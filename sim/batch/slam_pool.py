"""SLAM for the robots of a batch, in separate processes; the results are those of single robots."""

from collections.abc import Sequence
from dataclasses import dataclass
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from slam.closing import Closing
from slam.console.terminal import Terminal
from slam.env.config import EnvConfig
from slam.env.episode import Episode
from slam.env.occupancy_grid import Extent
from slam.errors import HopslamError, RobotError
from slam.odometry import Odometry, Twist2D
from slam.pose import Pose2D
from slam.robot import Observation
from slam.run.warm_up import warm_up
from slam.scan import LaserScan
from slam.scenario.schema import Scenario
from slam.sweep.process_pool import ONE_THREAD, environment, main_module_hidden
from slam.system import leave_terminal

Arrays = dict[str, NDArray[Any]]


class ScanOfRobot(NamedTuple):
    """Scan and odometry of one robot in one step."""

    robot: int
    world: int
    seed: int | None
    """Seed of the new episode; None within an episode."""
    scan: LaserScan
    odometry: Odometry
    T_map_base: Pose2D
    """True pose ``T_map_base``."""


class Estimated(NamedTuple):
    """Estimate of SLAM after one scan."""

    robot: int
    views: Arrays
    info: Arrays


@dataclass(frozen=True)
class SlamTask:
    """Scenarios and settings of a batch, with which a process runs SLAM for its robots."""

    config: EnvConfig
    scenarios: Sequence[Scenario]

    def take(self, episodes: dict[int, Episode], given: ScanOfRobot) -> Estimated:
        """Update the SLAM of this robot, or begin its episode."""
        observation = Observation(given.scan, given.odometry, given.T_map_base)
        if given.seed is None:
            episodes[given.robot].update(observation)
        else:
            scenario = self.scenarios[given.world]
            start, extent = scenario.robot.start.pose, Extent.of(scenario)
            episodes[given.robot] = Episode(self.config, scenario, extent, given.seed, start, observation)
        episode = episodes[given.robot]
        info = episode.info(Twist2D(), {}, "")
        slam = {key: np.asarray(value) for key, value in info.items() if key.startswith("slam_")}
        return Estimated(given.robot, episode.views(), slam)


class SlamPool(Closing):
    """Processes that run SLAM; each has a share of the robots."""

    def __init__(self, processes: int, task: SlamTask) -> None:
        warm_up(Terminal(stderr=True), task.scenarios[0].slam)
        self._pipes: list[Any] = []  # Any: their class depends on the operating system
        self._processes = []
        context = get_context("spawn")
        for _ in range(processes):
            near, far = context.Pipe()
            process = context.Process(target=_serve, args=(far, task), daemon=True)
            with environment(ONE_THREAD), main_module_hidden():
                process.start()
            far.close()
            self._pipes.append(near)
            self._processes.append(process)

    def estimate(self, scans: Sequence[ScanOfRobot]) -> list[Estimated]:
        """Run SLAM on these scans."""
        count = len(self._pipes)
        shares = [[given for given in scans if given.robot % count == k] for k in range(count)]
        try:
            for pipe, share in zip(self._pipes, shares, strict=True):
                pipe.send(share)
            answers = [pipe.recv() for pipe in self._pipes]
        except (EOFError, OSError) as error:
            raise RobotError("a process that ran SLAM for the batch has ended; make a new environment") from error
        for answer in answers:
            if isinstance(answer, HopslamError):
                raise answer
        return [found for answer in answers for found in answer]

    def close(self) -> None:
        for pipe in self._pipes:
            pipe.close()
        for process in self._processes:
            process.join(2.0)
            process.kill()


def _serve(pipe: Connection, task: SlamTask) -> None:
    """Run the episodes of some robots until the pipe is closed."""
    leave_terminal()
    episodes: dict[int, Episode] = {}
    while True:
        try:
            scans: list[ScanOfRobot] = pipe.recv()
        except (EOFError, OSError):
            return
        try:
            pipe.send([task.take(episodes, given) for given in scans])
        except HopslamError as error:
            pipe.send(error)  # for the environment to raise; any other error ends this process
