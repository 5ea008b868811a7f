"""The emulated URG-04LX: SCIP 1.1 when it gets power, SCIP 2.0 when asked, one answer a turn."""

from collections import deque
from dataclasses import dataclass, replace
from itertools import pairwise
from math import pi
from typing import Final

import numpy as np

from hardware.emulator.plant import Plant
from hardware.emulator.scip_replies import SensorSettings, reply_to, reply_to_scip1
from hardware.scip.commands import ScanRequest, note_of
from hardware.scip.frames import CommandDecoder
from hardware.scip.information import SensorParameters
from hardware.scip.reply import Reply
from hardware.scip.scan_data import ScanData, encode_scan
from slam.pose import FloatArray

PARAMETERS: Final = SensorParameters("URG-04LX(Hokuyo Automatic Co.,Ltd.)", 0.02, 5.6, 1024, 44, 725, 384, 0.1)
"""Abilities of a real one, firmware 3.1.04."""
_SECTORS: Final = 8
"""Parts in which the fan is swept, each with the world as it is in its middle."""
_EDGES: Final = [
    PARAMETERS.first + (PARAMETERS.last + 1 - PARAMETERS.first) * k // _SECTORS for k in range(_SECTORS + 1)
]
"""First step of each sector, and the step behind the last one."""
_EVENTS: Final = [
    *((first + end) / 2.0 * PARAMETERS.step_time for first, end in pairwise(_EDGES)),
    _EDGES[-1] * PARAMETERS.step_time,
]
"""Seconds from step 0 to the middle of each sector, and to the end of the fan."""
_QUEUE: Final = 16
"""Number of commands that wait for their turn; more are forgotten."""


@dataclass(frozen=True, slots=True)
class _WaitingCommand:
    """A command that waits; ``repeated`` if the same one waited already when it came."""

    text: str
    repeated: bool = False


class EmulatedUrg04lx:
    """Turns all the time; measures while the laser is on; answers one command at the end of every fan.

    ``drift`` is the share by which its clock runs faster than the plant's.
    """

    def __init__(self, plant: Plant, now: float = 0.0, drift: float = 0.0, paced: bool = True) -> None:
        self._plant = plant
        self._plant_began = now - plant.elapsed
        self._powered_at = now
        self._drift = drift
        self._paced = paced
        self._turn_began = now
        self._next = 0
        self._bearings = (np.arange(PARAMETERS.resolution) - PARAMETERS.front) * 2.0 * pi / PARAMETERS.resolution
        self._ranges = np.full(PARAMETERS.resolution, np.nan)
        self._whole = False
        self._latest: tuple[FloatArray, float] | None = None
        self._decoder = CommandDecoder()
        self._waiting: deque[_WaitingCommand] = deque(maxlen=_QUEUE)
        self._turns_until_scan = 0
        self._settings = SensorSettings(PARAMETERS)
        self.dead = False

    @property
    def baud(self) -> int:
        """Bit rate that the client asked for with SS."""
        return self._settings.baud

    @property
    def due(self) -> float:
        """Time of the middle of the next sector, or of the end of the fan."""
        return self._turn_began + _EVENTS[self._next]

    @property
    def wake(self) -> float:
        """Time of the next sector while it measures, so that little is left to do at the end of the fan."""
        return self.due if self._settings.laser else self._turn_began + _EVENTS[-1]

    @property
    def laser(self) -> bool:
        """True while it measures."""
        return self._settings.laser

    @property
    def sweep(self) -> tuple[FloatArray, FloatArray]:
        """Bearings in the sensor's frame, and the last range measured at each, nan before the first; (N,) each."""
        return self._bearings, self._ranges

    def set_dead(self, dead: bool) -> None:
        """Fall silent, or come back to life."""
        self.dead = dead

    def step(self) -> bytes:
        """Sweep a sector; at the end of the fan, talk."""
        if self._next < _SECTORS:
            self._sweep(self._next)
            self._next += 1
            return b""
        sent = self._end_of_fan()
        self._next = 0
        self._turn_began += PARAMETERS.scan_time
        self._whole = True
        return sent

    def receive(self, data: bytes, now: float) -> bytes:
        """Take commands, which wait for the end of the fan where the sensor is paced; else answer at once."""
        if self.dead:
            return b""
        for text in self._decoder.feed(data):
            self._waiting.append(_WaitingCommand(text, repeated=any(other.text == text for other in self._waiting)))
        sent = b""
        while self._waiting and not (self._paced or self._must_wait(self._waiting[0])):
            sent += self._answer(self._waiting.popleft(), now)
        return sent

    def _end_of_fan(self) -> bytes:
        if self._settings.laser and self._whole:
            self._latest = (self._ranges.copy(), self._time(self._turn_began))
        if self.dead:
            return b""
        sent = self._answer(self._waiting.popleft(), self.due) if self._waiting else b""
        return sent + self._stream()

    def _sweep(self, sector: int) -> None:
        if not self._settings.laser:
            self._whole, self._latest = False, None
            return
        first, last = _EDGES[sector : sector + 2]
        ahead = self._turn_began + first * PARAMETERS.step_time - self._plant_began - self._plant.elapsed
        self._ranges[first:last] = self._plant.ranges(self._bearings[first:last], ahead, PARAMETERS.step_time)

    def _answer(self, command: _WaitingCommand, now: float) -> bytes:
        settings, text = self._settings, command.text
        if command.repeated and settings.scip2:
            return Reply(text, "0B").encode()
        settings.time = time = self._time(now)
        was_measuring = settings.streaming
        reply = reply_to(settings, text) if settings.scip2 else reply_to_scip1(settings, text)
        self._powered_at += time - settings.time  # a reset begins the clock anew
        if settings.streaming is not was_measuring:
            self._turns_until_scan = 0
        if reply.status in ("00", "0") and reply.echo[:1] == "G":
            return self._single(ScanRequest.decode(reply.echo), command)
        return reply.encode()

    def _must_wait(self, command: _WaitingCommand) -> bool:
        """Tell whether a command asks for the latest scan, and there is none yet."""
        return command.text[:1] == "G" and self.laser and self._latest is None

    def _single(self, request: ScanRequest, command: _WaitingCommand) -> bytes:
        """Return the answer to GD, GS and G; none yet where there is no scan."""
        if self._latest is None:
            self._waiting.appendleft(command)
            return b""
        return self._scan(request, "0" if request.letters == "G" else "00", note_of(command.text))

    def _stream(self) -> bytes:
        """Return the next scan of MD or MS; the one swept while its command is answered does not count."""
        request = self._settings.streaming
        if request is None or self._latest is None:
            return b""
        if self._turns_until_scan:
            self._turns_until_scan -= 1
            return b""
        self._turns_until_scan = request.interval
        if request.scans:
            request = replace(request, scans=request.scans - 1)
            self._settings.streaming = request if request.scans else None
            self._settings.laser = request.scans > 0
        return self._scan(request, "99", self._settings.note)

    def _scan(self, request: ScanRequest, status: str, note: str) -> bytes:
        assert self._latest is not None
        ranges, time = self._latest
        clustered = _cluster(ranges[request.first : request.last + 1], max(request.cluster, 1))
        reply = encode_scan(ScanData(request, clustered, None if request.letters == "G" else time), status)
        return replace(reply, echo=reply.echo + note).encode()

    def _time(self, now: float) -> float:
        """Return the sensor's clock, seconds since it was powered or reset."""
        return (now - self._powered_at) * (1.0 + self._drift)


def _cluster(ranges: FloatArray, size: int) -> FloatArray:
    """Return the least range of every ``size`` neighbours, errors left out; inf where none has an echo."""
    if size == 1:
        return ranges
    padded = np.full(-(-len(ranges) // size) * size, np.nan)
    padded[: len(ranges)] = ranges
    nearest: FloatArray = np.where(np.isnan(padded), np.inf, padded).reshape(-1, size).min(axis=1)
    return nearest
