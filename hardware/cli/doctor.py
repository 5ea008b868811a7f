"""``hopslam doctor``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from slam.console.options import RecordWire
from slam.errors import InputError

if TYPE_CHECKING:
    from hardware.doctor.finding import Finding
    from slam.console.terminal import Terminal
    from slam.lidars import LidarName
    from slam.scan import LaserScan

_DMESG: Final = "the last lines of: sudo dmesg"
_SYSTEM_LOGS: Final = {"win32": "Ports in the Device Manager", "darwin": "USB in System Information"}
"""Where a system that is not Linux lists what was plugged in."""


def doctor(
    ports: Annotated[list[str] | None, typer.Argument(help="Ports to examine; default: all likely ones.")] = None,
    every_port: Annotated[
        bool, typer.Option("--all", help="Examine every serial port, including unlikely ones.")
    ] = False,
    lidar_baud: Annotated[int, typer.Option(metavar="RATE", help="First bit rate to try with a lidar.")] = 500000,
    png: Annotated[Path, typer.Option(metavar="FILE", help="Picture of a lidar's scan.")] = Path("scan.png"),
    record_wire: RecordWire = None,
) -> None:
    """Find the devices on the serial ports, or the reasons why they do not answer. Nothing moves.

    It examines the named ports; without names, those of lidars and USB adapters, and with --all every one. The exit
    code is 3 if a named port, or a found device, cannot be used, and if no device is found.

    [bold]Examples[/bold]

    hopslam doctor

    hopslam doctor /dev/ttyACM0 --png scan.png

    hopslam doctor socket://192.168.1.7:4001

    hopslam doctor /dev/ttyUSB0 --record-wire robot.wire
    """
    from hardware.doctor import examine
    from hardware.wire.session import WireSession
    from slam.console.terminal import Terminal

    console = Terminal()
    findings = []
    for port in ports or _ports_to_examine(every_port, console):
        with WireSession(record_wire) as wire:
            finding = examine(port, lidar_baud, wire)
        findings.append(finding)
        _print(finding, console)
        if finding.scan is not None:
            with console.waiting("drawing its scan (the first time on a machine compiles the line extraction)"):
                _draw(png, finding.scan, finding.model, port)
            console.print(f"its scan is drawn in {png}")
    if not _fit_for_use(findings, named=bool(ports)):
        raise typer.Exit(3)


def _ports_to_examine(every_port: bool, console: Terminal) -> list[str]:
    """Return the ports to examine if none is named, and print which ones are left out."""
    from hardware.usb_serial import listed_ports

    listed = listed_ports()
    if not listed:
        console.print(f"no serial ports; plug a device in, and look at {_SYSTEM_LOGS.get(sys.platform, _DMESG)}")
    chosen = [port for port in listed if port.likely or every_port]
    for port in listed:
        if port not in chosen:
            console.print(f"{port.device}: {port.description}, left alone; name it, or give --all, to examine it")
    if listed and not chosen:
        console.print("none of these ports looks like that of a robot or a lidar")
    return [port.device for port in chosen]


def _print(finding: Finding, console: Terminal) -> None:
    console.print(f"{finding.port}: {finding.words}")
    for fault in finding.faults:
        console.print(f"  fault: {fault}")
    if finding.advice:
        console.print(f"  advice: {finding.advice}")


def _fit_for_use(findings: list[Finding], named: bool) -> bool:
    counted = findings if named else [finding for finding in findings if finding.answered]
    return bool(counted) and all(finding.fine for finding in counted)


def _draw(png: Path, scan: LaserScan, model: LidarName, port: str) -> None:
    from slam.config import ChiSquareConfig
    from slam.lines.extraction import extract_segments
    from slam.run.pictures.scan_picture import draw_scan

    try:
        draw_scan(png, scan.points(), extract_segments(scan, ChiSquareConfig(sensor=model)), port)
    except OSError as error:
        raise InputError(f"{png}: cannot be written: {error.strerror}") from error
