"""``hopslam wire``."""

from pathlib import Path
from typing import Annotated

import typer


def wire(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="File that --record-wire has written.")],
    port: Annotated[str | None, typer.Option(metavar="PORT", help="Only this port.")] = None,
    raw: Annotated[bool, typer.Option("--raw", help="Show the bytes, too.")] = False,
) -> None:
    """List what passed over the ports of the devices, message by message.

    Seconds since the first byte, the port, > to the device or < from it, and the message of ARCOS or SCIP. A file that
    was cut off is read as far as it goes. The drivers play it as a device, at the port wire:FILE, or wire:FILE#PORT
    where it has several: it answers as the recorded device did.

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
