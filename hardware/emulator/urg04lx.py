"""The emulated URG-04LX: SCIP 1.1 at power-up, SCIP 2.0 on request, one answer per turn."""

from collections import deque
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from hardware.emulator.plant import Plant
from hardware.emulator.scip_replies import reply_to, reply_to_scip1
from hardware.emulator.sensor_settings import SensorSettings
from hardware.emulator.swept_fan import SECTORS, SweptFan
from hardware.scip.commands import ScanRequest, note_of
from hardware.scip.frames import CommandDecoder
from hardware.scip.information import SensorParameters
from hardware.scip.reply import Reply
from hardware.scip.scan_data import ScanData, encode_scan
from slam.pose import FloatArray

PARAMETERS: Final = SensorParameters("URG-04LX(Hokuyo Automatic Co.,Ltd.)", 0.02, 5.6, 1024, 44, 725, 384, 0.1)
"""Parameters of a real sensor, firmware 3.1.04."""
TABLE1_PARAMETERS: Final = SensorParameters("URG-04LX of Table 1 (simulated)", 0.06, 4.0, 192, 0, 127, 64, 0.1)
"""The paper's 128 beams, shifted by half a step, as SCIP counts whole steps from the front."""
_UNMEASURED: Final = 43
"""Number of steps after the last measured one, 725, that may be requested too; the sensor has 1024 steps per turn."""
_REBOOT: Final = 1.0
"""Seconds from power-up to the first answer: our choice, as the maker does not state it."""
_QUEUE: Final = 16
"""Number of commands that may wait; further ones are dropped."""


@dataclass(frozen=True, slots=True)
class _WaitingCommand:
    """A waiting command; ``repeated`` if the same one waited already."""

    text: str
    repeated: bool = False


class EmulatedUrg04lx:
    """Turns all the time; measures while the laser is on; answers one command at the end of every fan.

    ``drift`` is the relative error of its clock against the plant's (positive: fast).
    """

    def __init__(
        self,
        plant: Plant,
        now: float = 0.0,
        drift: float = 0.0,
        paced: bool = True,
        parameters: SensorParameters = PARAMETERS,
    ) -> None:
        self._parameters = parameters
        self._fan = SweptFan(plant, now, parameters)
        self._powered_at = now
        self._drift = drift
        self._paced = paced
        self._turn_began = now
        self._next = 0
        self._whole = False
        self._latest: tuple[FloatArray, float] | None = None
        self._decoder = CommandDecoder()
        self._waiting: deque[_WaitingCommand] = deque(maxlen=_QUEUE)
        self._turns_until_scan = 0
        self._settings = self._powered_up()
        self._answers_from = now
        self.dead = False

    @property
    def baud(self) -> int:
        """Bit rate that the client asked for with SS."""
        return self._settings.baud

    @property
    def due(self) -> float:
        """Time of the middle of the next sector, or of the end of the fan."""
        return self._turn_began + self._fan.events[self._next]

    @property
    def wake(self) -> float:
        """Time of the next sector while it measures, so that little work is left for the end of the fan."""
        return self.due if self._settings.laser else self._turn_began + self._fan.events[-1]

    @property
    def laser(self) -> bool:
        """True while it measures."""
        return self._settings.laser

    @property
    def sweep(self) -> tuple[FloatArray, FloatArray]:
        """Bearings in the sensor's frame, and the last range measured at each, nan before the first; (N,) each."""
        return self._fan.bearings, self._fan.ranges

    def set_dead(self, dead: bool) -> None:
        """Fall silent, or come back to life."""
        self.dead = dead

    def reboot(self, now: float) -> None:
        """Simulate a power failure: the sensor is silent for a while, and then in the state of power-up."""
        self._settings, self._latest, self._powered_at = self._powered_up(), None, now
        self._waiting.clear()
        self._answers_from = now + _REBOOT

    def step(self) -> bytes:
        """Sweep a sector; at the end of the fan, answer."""
        if self._next < SECTORS:
            self._sweep(self._next)
            self._next += 1
            return b""
        sent = self._end_of_fan()
        self._next = 0
        self._turn_began += self._parameters.scan_time
        self._whole = True
        return sent

    def receive(self, data: bytes, now: float) -> bytes:
        """Take commands, which wait for the end of the fan if the sensor is paced; otherwise answer at once."""
        if self.dead or now < self._answers_from:
            return b""
        for text in self._decoder.feed(data):
            self._waiting.append(_WaitingCommand(text, repeated=any(other.text == text for other in self._waiting)))
        sent = b""
        while self._waiting and not (self._paced or self._must_wait(self._waiting[0])):
            sent += self._answer(self._waiting.popleft(), now)
        return sent

    def _end_of_fan(self) -> bytes:
        if self._settings.laser and self._whole:
            self._latest = (self._fan.ranges.copy(), self._time(self._turn_began))
        if self.dead:
            return b""
        sent = self._answer(self._waiting.popleft(), self.due) if self._waiting else b""
        return sent + self._stream()

    def _sweep(self, sector: int) -> None:
        if not self._settings.laser:
            self._whole, self._latest = False, None
            return
        self._fan.sweep(sector, self._turn_began)

    def _answer(self, command: _WaitingCommand, now: float) -> bytes:
        settings, text = self._settings, command.text
        if command.repeated and settings.scip2:
            return Reply(text, "0B").encode()
        settings.time = time = self._time(now)
        was_measuring = settings.streaming
        reply = reply_to(settings, text) if settings.scip2 else reply_to_scip1(settings, text)
        self._powered_at += time - settings.time  # a reset restarts the clock
        if settings.streaming is not was_measuring:
            self._turns_until_scan = 0
        if reply.status in ("00", "0") and reply.echo[:1] == "G":
            return self._single(ScanRequest.decode(reply.echo), command)
        return reply.encode()

    def _must_wait(self, command: _WaitingCommand) -> bool:
        """Return True if a command asks for the latest scan, and there is none yet."""
        return command.text[:1] == "G" and self.laser and self._latest is None

    def _single(self, request: ScanRequest, command: _WaitingCommand) -> bytes:
        """Return the answer to GD, GS and G; empty before the first scan."""
        if self._latest is None:
            self._waiting.appendleft(command)
            return b""
        return self._scan(request, "0" if request.letters == "G" else "00", note_of(command.text))

    def _stream(self) -> bytes:
        """Return the next scan of MD or MS; the scan during which its command is answered does not count."""
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

    def _powered_up(self) -> SensorSettings:
        unmeasured = _UNMEASURED * self._parameters.resolution // PARAMETERS.resolution
        return SensorSettings(self._parameters, self._parameters.last + unmeasured)

    def _time(self, now: float) -> float:
        """Return the sensor's clock, seconds since it was powered or reset."""
        return (now - self._powered_at) * (1.0 + self._drift)


def _cluster(ranges: FloatArray, size: int) -> FloatArray:
    """Return the least range of every ``size`` neighbours, ignoring errors; inf if none has an echo."""
    if size == 1:
        return ranges
    padded = np.full(-(-len(ranges) // size) * size, np.nan)
    padded[: len(ranges)] = ranges
    nearest: FloatArray = np.where(np.isnan(padded), np.inf, padded).reshape(-1, size).min(axis=1)
    return nearest


class EmulatedTable1(EmulatedUrg04lx):
    """The lidar of the paper's Table 1: a URG-04LX with 128 beams."""

    def __init__(self, plant: Plant, now: float = 0.0, drift: float = 0.0, paced: bool = True) -> None:
        super().__init__(plant, now, drift, paced, TABLE1_PARAMETERS)
