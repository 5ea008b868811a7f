"""A wire recording in words: a line for each message of ARCOS, SCIP and LDROBOT, and for undecodable bytes."""

from collections.abc import Iterable, Iterator
from contextlib import suppress
from math import degrees
from typing import Final

import numpy as np

from hardware import DecodeError
from hardware.ldrobot import LdPacket
from hardware.scip.reply import Reply, decode_old_reply, find_reply
from hardware.scip.scan_data import decode_scan
from hardware.scip.status import status_meaning
from hardware.wire.events import WireEvent
from hardware.wire.messages import MessageSplitter, WireMessage
from hardware.wire.robot_words import RobotWords

_SILENCE: Final = 0.3
"""Seconds after which an incomplete message is given up."""
_SHOWN: Final = 24
"""Bytes shown of data that cannot be decoded."""
_TO, _FROM = ">", "<"


def list_wire(events: Iterable[WireEvent], raw: bool = False) -> Iterator[str]:
    """Yield the lines of a recording, with seconds since its first event; ``raw`` adds the bytes.

    A message is listed when its last byte has come.
    """
    ports: dict[str, _PortListing] = {}
    began: float | None = None
    for event in events:
        began = event.stamp if began is None else began
        head = f"{event.stamp - began:11.6f}  {event.port}  {event.kind}  "
        if raw and event.data:
            yield head + event.data.hex(" ")
        for words in ports.setdefault(event.port, _PortListing()).of_event(event):
            yield head + words


class _PortListing:
    """Reads both directions of one port."""

    def __init__(self) -> None:
        self._splitters = {_TO: MessageSplitter(b"\n"), _FROM: MessageSplitter(b"\n\n")}
        self._heard = {_TO: 0.0, _FROM: 0.0}
        self._robot = RobotWords()

    def of_event(self, event: WireEvent) -> Iterator[str]:
        """Describe what this event completes."""
        if event.kind == "=":
            yield f"{event.text} baud"
        elif event.kind == "-":
            yield f"lost: {event.text}" if event.text else "closed"
        else:
            splitter = self._splitters[event.kind]
            if event.stamp - self._heard[event.kind] > _SILENCE:
                yield from (self._words(event.kind, left) for left in splitter.flush())
            self._heard[event.kind] = event.stamp
            yield from (self._words(event.kind, message) for message in splitter.feed(event.data))

    def _words(self, kind: str, message: WireMessage) -> str:
        if message.protocol == "arcos":
            return self._robot.of_command(message.data) if kind == _TO else self._robot.of_packet(message.data)
        if message.protocol == "ldrobot":
            return _points(message.data)
        if message.protocol == "scip":
            return message.data.decode("ascii") if kind == _TO else _answer(message.data)
        shown = message.data[:_SHOWN].hex(" ") + " ..." * (len(message.data) > _SHOWN)
        return f"{len(message.data)} bytes that are not a whole message: {shown}"


def _points(packet: bytes) -> str:
    """Describe a packet of a lidar of LDROBOT."""
    try:
        points = LdPacket.decode(packet)
    except DecodeError as error:
        return f"points: {error}"
    first, last, speed = (degrees(angle) for angle in (points.first, points.last, points.speed))
    echoes = points.ranges[np.isfinite(points.ranges)]
    reach = f" {echoes.min():.3f} to {echoes.max():.3f} m" if len(echoes) else ""
    turning = f"{speed:.0f} deg/s, sensor's clock {points.time:.3f} s"
    return f"points {first:.2f} to {last:.2f} deg clockwise, {len(echoes)} echoes{reach}, {turning}"


def _answer(text: bytes) -> str:
    """Describe an answer of a lidar."""
    lines = tuple(text.split(b"\n"))
    reply = find_reply(lines) or _old(lines)
    if reply is None:
        return f"damaged answer of {len(lines)} lines: {lines[0].decode('ascii')[:64]}"
    with suppress(DecodeError):
        scan = decode_scan(reply)
        echoes = scan.ranges[np.isfinite(scan.ranges)]
        reach = f", {echoes.min():.3f} to {echoes.max():.3f} m" if len(echoes) else ""
        time = "" if scan.time is None else f", sensor's clock {scan.time:.3f} s"
        return f"{reply.echo}: scan of {len(scan.ranges)} ranges, {len(echoes)} echoes{reach}{time}"
    words = f"{reply.echo}: status {reply.status}, {status_meaning(reply.echo, reply.status)}"
    return "; ".join([words, *(line.decode("ascii").rstrip(";") for line in reply.lines)])


def _old(lines: tuple[bytes, ...]) -> Reply | None:
    with suppress(DecodeError):
        return decode_old_reply(lines)
    return None
