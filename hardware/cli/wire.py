"""``hopslam wire``."""

from pathlib import Path
from typing import Annotated

import typer


def wire(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="File that --record-wire has written.")],
    port: Annotated[str | None, typer.Option(metavar="PORT", help="List only this port.")] = None,
    raw: Annotated[bool, typer.Option("--raw", help="Also show the bytes.")] = False,
) -> None:
    """List the recorded traffic on the ports of the devices, message by message.

    Each line has the seconds since the first byte, the port, > to the device or < from it, and the message. A truncated
    file is read as far as possible. A driver can open the port wire:FILE, or wire:FILE#PORT if it has several: the
    recording then answers like the device.

    [bold]Examples[/bold]

    hopslam run corridor --backend hardware --dry-run --record-wire robot.wire

    hopslam wire robot.wire

    hopslam wire robot.wire --port /dev/ttyUSB0 --raw

    hopslam doctor wire:robot.wire#/dev/ttyACM0

    hopslam run corridor --backend hardware --dry-run --set hardware.robot_port=wire:robot.wire#/dev/ttyUSB0 --set
    hardware.lidar_port=wire:robot.wire#/dev/ttyACM0
    """
    from hardware.wire.events import read_wire
    from hardware.wire.listing import list_wire
    from slam.errors import InputError

    events = [event for event in read_wire(file) if port in (None, event.port)]
    if not events:
        raise InputError(f"{file}: nothing was recorded{f' at {port}' if port else ''}; without --port all is listed")
    for line in list_wire(events, raw):
        print(line)
