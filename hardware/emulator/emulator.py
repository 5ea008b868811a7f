"""Both emulated devices in real time, on a thread of their own."""

import select
import socket
import threading
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Final, Self, TypeVar

import numpy as np

from hardware.arcos.config_packet import ArcosConfig
from hardware.emulator.p3dx import FACTORY_CONFIG, EmulatedP3dx
from hardware.emulator.plant import Plant
from hardware.emulator.ports import Port, pseudo_terminal
from hardware.emulator.serial_line import ConnectedDevice, EmulatedLidar, LineNoise
from hardware.emulator.urg04lx import EmulatedUrg04lx
from hardware.lidars.models import LIDAR_DEVICES, lidar_emulator
from hardware.wire.session import WireSession
from slam.closing import Closing
from slam.pose import FloatArray, Pose2D, unit_vectors
from slam.scenario.schema import Scenario

_FARTHEST_BEHIND: Final = 1.0
"""Seconds by which the emulated world may fall behind the clock; beyond that, it skips time."""
_LONGEST_WAIT: Final = 60.0
"""Longest wait, seconds: a device that is stalled for an unlimited time has no next event."""


def emulated_lidar(scenario: Scenario) -> str:
    """Return the model of the scenario's lidar; a URG-04LX for a model that has no emulator."""
    return scenario.lidar.model if scenario.lidar.model in LIDAR_DEVICES else "urg04lx"


@dataclass(frozen=True, slots=True, eq=False)
class EmulatorState:
    """The emulated world for a viewer; metres, radians, seconds since the emulator was made."""

    stamp: float
    T_map_base: Pose2D
    T_odom_base: Pose2D
    """Pose of the base by its wheels, in the frame of its start."""
    points: FloatArray
    """(N, 2): the ends of the beams of the last turn, sensor frame; empty while the laser is off."""
    stalled: bool
    bearings: FloatArray
    """(B,): directions of the beams, radians, sensor frame."""
    ranges: FloatArray
    """(B,): newest range in each direction, metres; nan where nothing is measured, or while the laser is off."""
    volts: float
    """Voltage of the robot's battery."""


_T = TypeVar("_T")


def device_name(lidar: str) -> str:
    """Return the device name of this model; the lidar of Table 1 is a URG-04LX with fewer beams."""
    return "urg04lx" if lidar == "table1" else lidar


class Emulator(Closing):
    """A P3-DX and a lidar at two ports; use it as a context manager.

    ``noise`` damages bytes on both lines and ``drift`` is the error of the lidar's clock. With ``lidar_on_usb`` no bit
    rate limits its line; with ``paced`` it answers as slowly as a real one, one command per turn. ``wire`` records what
    passes at both ports, and ``lidar`` is the model of the lidar.

    All devices belong to the thread; other threads reach them through ``do``. Events are handled in the order of their
    times, however late the thread wakes up.
    """

    def __init__(
        self,
        plant: Plant,
        robot_port: Port | None = None,
        lidar_port: Port | None = None,
        noise: LineNoise = LineNoise(),  # noqa: B008  # frozen
        drift: float = 0.0,
        lidar_on_usb: bool = True,
        paced: bool = True,
        seed: int = 0,
        robot_config: ArcosConfig = FACTORY_CONFIG,
        wire: WireSession | None = None,
        lidar: str = "urg04lx",
    ) -> None:
        now = time.monotonic()
        wire = wire or WireSession()
        self._plant = plant
        self.p3dx = EmulatedP3dx(plant, now, robot_config)
        self._model = lidar
        self.scanner: EmulatedLidar = lidar_emulator(lidar)(plant, now, drift, paced)
        robot_port, lidar_port = robot_port or pseudo_terminal(), lidar_port or pseudo_terminal()
        self.robot = ConnectedDevice(self.p3dx, robot_port, True, 2 * seed, noise, wire)
        self.lidar = ConnectedDevice(self.scanner, lidar_port, not lidar_on_usb, 2 * seed + 1, noise, wire)
        self._devices = (self.robot, self.lidar)
        self._calls: deque[Callable[[], object]] = deque()
        self._schedule: list[tuple[float, Callable[[], object]]] = []
        self._began = now
        self._wake, self._waker = socket.socketpair()
        self._stopping = False
        self._lag = 0.0
        self._thread = threading.Thread(target=self._serve, name="emulator", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    @property
    def urg04lx(self) -> EmulatedUrg04lx:
        """The lidar, if it is a URG-04LX."""
        assert isinstance(self.scanner, EmulatedUrg04lx)
        return self.scanner

    @property
    def port_settings(self) -> list[str]:
        """Settings of a scenario that name both ports."""
        ports = [f"hardware.robot_port={self.robot.port.address}", f"hardware.lidar_port={self.lidar.port.address}"]
        return [*ports, f"lidar.model={device_name(self._model)}"]

    @property
    def now(self) -> float:
        """Time of the emulated world, seconds: the host's monotonic clock, minus the skipped time."""
        return time.monotonic() - self._lag

    @property
    def truth(self) -> tuple[float, Pose2D]:
        """True pose ``T_map_base``, and its time, seconds of the host's monotonic clock."""
        return self.do(lambda: (self.p3dx.moved_until + self._lag, self._plant.T_map_base))

    @property
    def state(self) -> EmulatorState:
        """Present state of the world."""
        return self.do(self._state)

    def schedule(self, at: float, call: Callable[[], object]) -> None:
        """Make the thread call this ``at`` seconds after the emulator was made; only before the emulator is entered."""
        self._schedule.append((self._began + at, call))
        self._schedule.sort(key=lambda item: -item[0])

    def do(self, call: Callable[[], _T]) -> _T:
        """Make the thread call this between two of its actions, and return the result."""
        result: Future[_T] = Future()
        self._calls.append(lambda: result.set_result(call()))
        self._waker.send(b"!")
        return result.result()

    def close(self) -> None:
        """Stop the thread, and unplug both ports."""
        if self._thread.is_alive():
            self._stopping = True
            self._waker.send(b"!")
            self._thread.join()
            self._wake.close()
            self._waker.close()

    def _state(self) -> EmulatorState:
        bearings, ranges = self.scanner.sweep
        echoes = np.isfinite(ranges) & self.scanner.laser
        near = ranges[echoes, None] * unit_vectors(bearings[echoes])
        plant = self._plant
        return EmulatorState(
            self.p3dx.moved_until - self._began, plant.T_map_base, plant.odometry, near, plant.stalled,
            bearings, np.where(self.scanner.laser, ranges, np.nan), self.p3dx.reports.battery,
        )  # fmt: skip

    def _serve(self) -> None:
        while not self._stopping:
            self._catch_up()
            for connected in self._devices:
                connected.take(self.now)
            while self._schedule and self._schedule[-1][0] <= self.now:
                self._calls.append(self._schedule.pop()[1])
            while self._calls:
                self._calls.popleft()()
            for connected in self._devices:
                connected.flush(self.now)
            self._wait()
        for connected in self._devices:
            connected.port.close()

    def _catch_up(self) -> None:
        """Do everything that is due, in the order of time."""
        first = min(self._devices, key=lambda connected: connected.device.due)
        self._lag += max(0.0, self.now - first.device.due - _FARTHEST_BEHIND)
        while first.device.due <= self.now:
            first.step()
            first = min(self._devices, key=lambda connected: connected.device.due)

    def _wait(self) -> None:
        times = [connected.wake for connected in self._devices] + [at for at, _ in self._schedule[-1:]]
        timeout = min(max(0.0, min(times) - self.now), _LONGEST_WAIT)
        filenos = [fileno for connected in self._devices for fileno in connected.filenos(self.now)]
        ready, _, _ = select.select([*filenos, self._wake.fileno()], [], [], timeout)
        if self._wake.fileno() in ready:
            self._wake.recv(64)
