"""The robot of an environment, from reset to reset."""

import threading
import weakref
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic
from typing import Final

from slam.console.terminal import Terminal
from slam.env.occupancy_grid import warm_up_occupancy_grid
from slam.errors import InputError, RobotError
from slam.odometry import Twist2D
from slam.robot import Observation, Restartable, Robot
from slam.run.backends import is_restartable, make_robot
from slam.run.gym_arrays import nearest_beams
from slam.run.loop import step_patiently
from slam.run.warm_up import warm_up
from slam.scan import LaserScan
from slam.scenario.lidar_config import LidarConfig
from slam.scenario.schema import Scenario

_BRAKING: Final = 5.0
"""Seconds that a robot has to come to rest."""
_REST: Final = Twist2D(0.005, 0.01)
"""A robot that is slower than this, m/s and rad/s, is at rest."""


class RobotSession:
    """The robot of an environment; it is stopped when it is closed, and when this object is garbage-collected.

    A ``Restartable`` robot is set back to its start if possible; every other one is closed and opened again.
    """

    def __init__(self, backend: str, *, yes: bool, dry_run: bool) -> None:
        options = _backend_options(backend, yes, dry_run)
        self.restartable = is_restartable(backend)  # an unknown name is refused here
        """True if an episode begins at the start of its scenario; otherwise it begins at the robot's pose."""
        self._backend, self._options = backend, options
        self._robot: Robot | None = None
        self._scenario: Scenario | None = None
        self._loss: weakref.finalize[..., RobotSession] | None = None

    @property
    def running(self) -> bool:
        """True while there is a robot."""
        return self._robot is not None

    @property
    def robot(self) -> Robot:
        """The robot; RobotError before the first start and after close."""
        if self._robot is None:
            raise RobotError("the environment has no robot yet: call reset() first")
        return self._robot

    def start(self, scenario: Scenario, seed: int) -> Observation:
        """Begin an episode in this scenario, and take the first scan; RobotError if another lidar made it."""
        if self._scenario is scenario and isinstance(self._robot, Restartable):
            self._robot.restart(seed)
        else:
            self._open(scenario, seed)
        first = self.robot.observe()
        if first is None:
            raise RobotError("the robot gave no scan at all")
        _require_lidar(first.scan, scenario.lidar)
        return first

    def step(self, command: Twist2D, patience: float) -> tuple[Twist2D, Observation | None]:
        """Drive until the next scan; return the command as applied, and the scan, None if there are no more."""
        taken, _ = step_patiently(self._drive_and_observe, command, patience)
        return taken

    def stand(self) -> None:
        """Command no motion."""
        if self._robot is not None:
            self._robot.drive(Twist2D())

    def come_to_rest(self, see: Callable[[Observation], object]) -> None:
        """Brake; ``see`` gets each scan until the robot is at rest."""
        until = monotonic() + _BRAKING
        while self._robot is not None and monotonic() < until:
            _, observation = self._drive_and_observe(Twist2D())
            if observation is None:
                return
            see(observation)
            twist = observation.odometry.twist
            if abs(twist.linear) < _REST.linear and abs(twist.angular) < _REST.angular:
                return

    @contextmanager
    def stopping(self) -> Iterator[None]:
        """Stop the robot after any error in the block; after wrong input it may continue, otherwise it is closed."""
        try:
            yield
        except InputError:
            self.stand()
            raise
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Stop the robot and free its devices; closing twice is allowed."""
        robot, self._robot, self._scenario = self._robot, None, None
        if robot is not None and self._loss is not None:
            self._loss.detach()
            robot.__exit__(None, None, None)

    def _drive_and_observe(self, command: Twist2D) -> tuple[Twist2D, Observation | None]:
        applied = self.robot.drive(command)
        return applied, self.robot.observe()

    def _open(self, scenario: Scenario, seed: int) -> None:
        """Open a robot that can still observe after the last scan of an episode, until it has come to rest."""
        self.close()
        longer = scenario.model_copy(update={"duration": scenario.duration + 2.0 * _BRAKING})
        robot = make_robot(self._backend, longer, seed=seed, **self._options)
        if not self.restartable:  # it may be real: nothing is compiled while it drives
            warm_up(Terminal(stderr=True), scenario.slam)
            warm_up_occupancy_grid()
        robot.__enter__()
        self._robot, self._scenario = robot, scenario
        self._loss = weakref.finalize(self, _stop_abandoned, robot)


def _backend_options(backend: str, yes: bool, dry_run: bool) -> dict[str, bool]:
    """Return the options of the back end; InputError for options that do not fit it, and for a recorded log."""
    if backend == "replay":
        raise InputError("backend='replay': a recorded log obeys no agent; run: hopslam replay LOG")
    if backend != "hardware" and (yes or dry_run):
        raise InputError("yes and dry_run are for the real robot; add backend='hardware'")
    options = {"hardware": {"yes": yes, "dry_run": dry_run, "newest": True}, "ros": {"newest": True}}
    return options.get(backend, {})


def _stop_abandoned(robot: Robot) -> None:
    """Stop a robot whose owner is gone.

    The garbage collector may call this from a thread that the robot waits for when it is closed; then another thread
    closes it.
    """
    if threading.current_thread() is threading.main_thread():
        robot.__exit__(None, None, None)
    else:
        threading.Thread(target=robot.__exit__, args=(None, None, None)).start()


def _require_lidar(scan: LaserScan, config: LidarConfig) -> None:
    """Raise RobotError if a scan does not cover the field of view; the number of its beams does not matter."""
    given, expected = scan.lidar, config.description.lidar
    blind = int((nearest_beams(given, expected) == given.beams).sum())
    if blind or given.range_max != expected.range_max:
        raise RobotError(
            f"the robot's scans have {given.beams} beams and reach {given.range_max:g} m; those of lidar.model "
            f"{config.model} have {expected.beams}, {blind} of them outside that fan, and reach "
            f"{expected.range_max:g} m: set lidar.model to the robot's lidar"
        )
