"""The emulator as a program: it says where its devices are, and runs until it is interrupted."""

from __future__ import annotations

import json
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from threading import Event

from hardware.emulator.emulator import Emulator
from hardware.emulator.faults import Fault
from hardware.emulator.plant import Plant
from hardware.emulator.ports import Port, PtyPort, TcpPort
from hardware.emulator.wire import Noise
from slam.errors import InputError


def serve(
    plant: Plant,
    link_dir: Path | None,
    tcp: bool,
    faults: Sequence[str],
    noise: Noise,
    drift: float,
    rs232: bool,
    seed: int,
) -> None:
    """Print one line of JSON with the addresses of both ports when they are ready, and serve until interrupted.

    InputError for a fault that is none, or a folder that cannot be used.
    """
    planned = [Fault.parse(text) for text in faults]
    robot_port, lidar_port = _ports(link_dir, tcp)
    emulator = Emulator(plant, robot_port, lidar_port, noise, drift, not rs232, seed=seed)
    for fault in planned:
        fault.plan(emulator)
    with suppress(KeyboardInterrupt), emulator:
        print(json.dumps({"p3dx": robot_port.address, "urg04lx": lidar_port.address}), flush=True)
        Event().wait()


def _ports(link_dir: Path | None, tcp: bool) -> tuple[Port, Port]:
    if tcp:
        return TcpPort(), TcpPort()
    if link_dir is None:
        return PtyPort(), PtyPort()
    try:
        link_dir.mkdir(parents=True, exist_ok=True)
        return PtyPort(link_dir / "p3dx"), PtyPort(link_dir / "urg04lx")
    except OSError as error:
        raise InputError(f"{link_dir}: cannot hold the links to the devices: {error.strerror}") from error
