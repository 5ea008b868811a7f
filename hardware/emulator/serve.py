"""The emulator as a program, which runs until it is interrupted, and its view for the rerun viewer."""

import json
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext, suppress
from dataclasses import replace
from itertools import count
from pathlib import Path
from time import sleep
from typing import Final, TextIO

import numpy as np

from hardware.emulator.emulator import Emulator, EmulatorState, device_name
from hardware.emulator.faults import TimedFault
from hardware.emulator.p3dx import FACTORY_CONFIG
from hardware.emulator.plant import Plant
from hardware.emulator.ports import Port, TcpPort, pseudo_terminal
from hardware.emulator.serial_line import LineNoise
from hardware.wire.session import WireSession
from slam.errors import InputError
from slam.files.tum import format_tum
from slam.pose import Pose2D
from slam.run.viewer.broadcast import Broadcast
from slam.run.viewer.palette import NO_SEGMENT
from slam.run.viewer.scene import Event, Frame, Scene
from slam.scenario.schema import Scenario

_TRUTH_PERIOD: Final = 0.05
"""Seconds between two true poses."""
_SHOWN_EVERY: Final = 2
"""Number of true poses from one state that viewers get to the next."""


def serve(
    plant: Plant,
    link_dir: Path | None,
    tcp: bool,
    faults: Sequence[str],
    noise: LineNoise,
    drift: float,
    rs232: bool,
    seed: int,
    truth: Path | None,
    watchdog: float,
    shows: Sequence[Callable[[EmulatorState], object]] = (),
    wire: WireSession | None = None,
    lidar: str = "urg04lx",
) -> None:
    """Print one line of JSON with the addresses of both ports when they are ready, and serve until interrupted.

    ``truth`` is a file for the true poses of the base as TUM text, 20 per second, stamped by the host's monotonic
    clock; each of ``shows`` gets the state 10 times per second. ``lidar`` is the model that is emulated, ``drift``
    the relative error of its clock; with ``rs232`` its line is as slow as its bit rate. InputError for an unknown
    fault, and for a file or folder that cannot be used.
    """
    planned = [TimedFault.parse(text) for text in faults]
    robot_port, lidar_port = _ports(link_dir, tcp, device_name(lidar))
    config = replace(FACTORY_CONFIG, watchdog=watchdog)
    emulator = Emulator(
        plant,
        robot_port,
        lidar_port,
        noise,
        drift,
        not rs232,
        seed=seed,
        robot_config=config,
        wire=wire,
        lidar=lidar,
    )
    for fault in planned:
        fault.schedule(emulator)
    with suppress(KeyboardInterrupt), _opened(truth) as file, emulator:
        print(json.dumps({"p3dx": robot_port.address, device_name(lidar): lidar_port.address}), flush=True)
        for tick in count():
            sleep(_TRUTH_PERIOD)
            if file is not None:
                file.write(format_tum(*emulator.truth) + "\n")
            if shows and tick % _SHOWN_EVERY == 0:
                state = emulator.state
                for show in shows:
                    show(state)


def _opened(truth: Path | None) -> AbstractContextManager[TextIO | None]:
    try:
        return nullcontext() if truth is None else truth.open("w", encoding="utf-8", buffering=1)
    except OSError as error:
        raise InputError(f"--truth {truth}: cannot be written: {error.strerror}") from error


def _ports(link_dir: Path | None, tcp: bool, lidar: str) -> tuple[Port, Port]:
    if tcp:
        return TcpPort(), TcpPort()
    if link_dir is None:
        return pseudo_terminal(), pseudo_terminal()
    try:
        link_dir.mkdir(parents=True, exist_ok=True)
        return pseudo_terminal(link_dir / "p3dx"), pseudo_terminal(link_dir / lidar)
    except OSError as error:
        raise InputError(f"{link_dir}: cannot hold the links to the devices: {error.strerror}") from error


def emulator_scene(scenario: Scenario) -> Scene:
    """Return a scene of the true walls without a map and curves, as nothing is estimated."""
    start, mount = scenario.robot.start.pose, scenario.lidar.mount.pose
    return Scene(mount, start, outlines=tuple(scenario.world.outlines(scenario.lidar.height)), plots=())


class EmulatorView:
    """Sends states to the viewer."""

    def __init__(self, broadcast: Broadcast, scene: Scene) -> None:
        self._broadcast, self._scene = broadcast, scene
        self._index, self._stalled = 0, False

    def show(self, state: EmulatorState) -> None:
        """Send a state, and an event where the wheels stall or turn again."""
        events = []
        if state.stalled is not self._stalled:
            self._stalled = state.stalled
            words = "stalled: a wheel cannot turn" if state.stalled else "the wheels turn again"
            events.append(Event(self._index, state.stamp, "WARN", words))
        self._broadcast.show(self._frame(state), events)
        self._index += 1

    def _frame(self, state: EmulatorState) -> Frame:
        odometry: Pose2D = self._scene.T_map_odom @ state.T_odom_base
        points = (state.T_map_base @ self._scene.T_base_laser).transform(state.points)
        grey = np.full(len(points), NO_SEGMENT, np.uint32)
        return Frame(
            self._index, state.stamp, None, odometry, state.T_map_base, points, grey, np.empty((0, 2, 2)), grey[:0]
        )
