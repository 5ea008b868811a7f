"""Both devices in real time, on a thread of their own."""

from __future__ import annotations

import os
import select
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Final, Self

import numpy as np

from hardware.arcos.config_packet import ArcosConfig
from hardware.emulator.emulator_state import EmulatorState
from hardware.emulator.motion import FACTORY
from hardware.emulator.p3dx import EmulatedP3dx
from hardware.emulator.plant import Plant
from hardware.emulator.ports import Port, PtyPort
from hardware.emulator.station import Station
from hardware.emulator.urg04lx import EmulatedUrg04lx
from hardware.emulator.wire import Noise
from slam.closing import Closing
from slam.pose import Pose2D, unit_vectors

_FARTHEST_BEHIND: Final = 1.0
"""Seconds: a machine that falls behind by more than this lets the emulated world skip time."""
_LONGEST_WAIT: Final = 60.0
"""Seconds: a stall without an end has no time at which it ends."""


class Emulator(Closing):
    """A P3-DX and a URG-04LX at two ports; use it as a context manager.

    ``noise`` is on both lines and ``drift`` in the lidar's clock. ``lidar_on_usb`` sets its line free of any bit rate;
    with ``paced`` it answers as slowly as a real one, one command a turn.

    All devices belong to the thread; others reach them through ``do``. What happens at one time is done in the order of
    time, however late the thread wakes up.
    """

    def __init__(
        self,
        plant: Plant,
        robot_port: Port | None = None,
        lidar_port: Port | None = None,
        noise: Noise = Noise(),  # noqa: B008  # frozen
        drift: float = 0.0,
        lidar_on_usb: bool = True,
        paced: bool = True,
        seed: int = 0,
        robot_config: ArcosConfig = FACTORY,
    ) -> None:
        now = time.monotonic()
        self._plant = plant
        self.p3dx = EmulatedP3dx(plant, now, robot_config)
        self.urg04lx = EmulatedUrg04lx(plant, now, drift, paced)
        self.robot = Station(self.p3dx, robot_port or PtyPort(), True, 2 * seed, noise)
        self.lidar = Station(self.urg04lx, lidar_port or PtyPort(), not lidar_on_usb, 2 * seed + 1, noise)
        self._stations = (self.robot, self.lidar)
        self._calls: deque[Callable[[], object]] = deque()
        self._plan: list[tuple[float, Callable[[], object]]] = []
        self._began = now
        self._wake_read, self._wake_write = os.pipe()
        self._stopping = False
        self._lag = 0.0
        self._thread = threading.Thread(target=self._serve, name="emulator", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    @property
    def now(self) -> float:
        """The time of the emulated world, seconds: the host's monotonic clock, less what was skipped."""
        return time.monotonic() - self._lag

    @property
    def truth(self) -> tuple[float, Pose2D]:
        """Where the base really is, ``T_map_base``, and when that was, seconds of the host's monotonic clock."""
        told: list[tuple[float, Pose2D]] = []
        self.do(lambda: told.append((self.p3dx.moved_until + self._lag, self._plant.T_map_base)))
        return told[0]

    def look(self) -> EmulatorState:
        """What a viewer shows of it now."""
        seen: list[EmulatorState] = []
        self.do(lambda: seen.append(self._glimpse()))
        return seen[0]

    def plan(self, at: float, call: Callable[[], object]) -> None:
        """Let the thread do this ``at`` seconds after the emulator was made; before it is entered only."""
        self._plan.append((self._began + at, call))
        self._plan.sort(key=lambda item: -item[0])

    def do(self, call: Callable[[], object]) -> None:
        """Let the thread do this, between two things of its own, and wait until it has."""
        done = threading.Event()

        def run() -> None:
            call()
            done.set()

        self._calls.append(run)
        os.write(self._wake_write, b"!")
        done.wait()

    def close(self) -> None:
        """Stop, and pull both plugs."""
        if self._thread.is_alive():
            self._stopping = True
            os.write(self._wake_write, b"!")
            self._thread.join()
            os.close(self._wake_read)
            os.close(self._wake_write)

    def _glimpse(self) -> EmulatorState:
        bearings, ranges = self.urg04lx.sweep
        echoes = np.isfinite(ranges) & self.urg04lx.laser
        near = ranges[echoes, None] * unit_vectors(bearings[echoes])
        plant = self._plant
        return EmulatorState(self.p3dx.moved_until - self._began, plant.T_map_base, plant.odometry, near, plant.stalled)

    def _serve(self) -> None:
        while not self._stopping:
            self._catch_up()
            for station in self._stations:
                station.take(self.now)
            while self._plan and self._plan[-1][0] <= self.now:
                self._calls.append(self._plan.pop()[1])
            while self._calls:
                self._calls.popleft()()
            for station in self._stations:
                station.flush(self.now)
            self._wait()
        for station in self._stations:
            station.port.close()

    def _catch_up(self) -> None:
        """Everything that was due until now, in the order of time."""
        first = min(self._stations, key=lambda station: station.device.due)
        self._lag += max(0.0, self.now - first.device.due - _FARTHEST_BEHIND)
        while first.device.due <= self.now:
            first.step()
            first = min(self._stations, key=lambda station: station.device.due)

    def _wait(self) -> None:
        times = [station.wake for station in self._stations] + [at for at, _ in self._plan[-1:]]
        timeout = min(max(0.0, min(times) - self.now), _LONGEST_WAIT)
        filenos = [fileno for station in self._stations for fileno in station.filenos(self.now)]
        ready, _, _ = select.select([*filenos, self._wake_read], [], [], timeout)
        if self._wake_read in ready:
            os.read(self._wake_read, 64)
