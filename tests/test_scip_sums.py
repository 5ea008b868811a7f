"""Line sums of the emulated lidar, checked by a reader written from the specification (Hokuyo C-42-03320B) alone."""

import numpy as np
import pytest

from hardware import DecodeError
from hardware.emulator.urg04lx import EmulatedUrg04lx
from hardware.scip.encoding import check_sum
from hardware.scip.reply import Reply, decode_reply
from sim.plant import SimPlant
from slam.pose import FloatArray
from tests.rooms import room_scenario

INFORMATION = ("VV", "PP", "II")


def is_right(command: bytes, line: bytes) -> bool:
    """Add all characters, keep the six lowest bits, add 30H. In ``KEY:value;`` lines the last semicolon is left out."""
    text, found = line[:-1], line[-1]
    if command[:2].decode() in INFORMATION and text.endswith(b";"):
        text = text[:-1]
    total = 0
    for character in text:
        total += character
    return found == (total & 0b111111) + 0x30


class Flicker(SimPlant):
    """A world of random ranges, new in every scan, so that every character occurs at every place of a line."""

    rng = np.random.default_rng(7)

    def ranges(self, bearings: FloatArray, ahead: float = 0.0, increment: float = 0.0) -> FloatArray:
        return np.round(self.rng.uniform(0.02, 5.6, len(bearings)), 3)


def answers_of(commands: list[bytes], turns: int = 0) -> list[list[bytes]]:
    """Return the lines of every answer within ``turns`` turns of a sensor in SCIP 2.0 with its laser on."""
    lidar = EmulatedUrg04lx(Flicker(room_scenario((-1.0, 1.0), (-1.0, 1.0))), paced=False)
    said = b""
    for command in (b"SCIP2.0", b"BM", *commands):
        said += lidar.receive(command + b"\n", lidar.due)
    said += b"".join(lidar.step() for _ in range(9 * turns))  # eight sectors and the end of the fan
    return [answer.split(b"\n") for answer in said.split(b"\n\n") if answer][2:]


def test_a_thousand_scans_have_no_wrong_sum() -> None:
    scans = answers_of([b"MD0044072501000"], turns=1002)[1:]
    lines = [line for echo, *lines in scans for line in lines if echo.startswith(b"MD")]
    assert len(scans) >= 1000
    assert len(lines) == len(scans) * 34  # status, time, and 32 lines of data
    assert sum(line[:-1].endswith(b";") for line in lines) > 300  # a semicolon may be the last digit of data: 11
    assert [line for line in lines if not is_right(b"MD", line)] == []


@pytest.mark.parametrize("command", [b"VV", b"PP", b"II", b"VV;note", b"QT", b"TM0", b"SS115200", b"XX"])
def test_every_kind_of_answer_has_right_sums(command: bytes) -> None:
    ((echo, *lines),) = answers_of([command])
    assert echo == command
    assert all(is_right(command, line) for line in lines)


def test_two_digits_and_single_scans_have_right_sums() -> None:
    for command in (b"MS0000076801001", b"MD0000076803001", b"MD0001000100001"):
        *_, (echo, *lines) = answers_of([command], turns=3)
        assert echo[:2] == command[:2]
        assert lines
        assert all(is_right(command, line) for line in lines)


@pytest.mark.parametrize("command", [b"GD0044072501;a note", b"GS0384038400;x", b"MD0044072501002;a note"])
def test_scans_repeat_the_string_of_their_command(command: bytes) -> None:
    """The echo repeats the text after the semicolon, and so do the scans of MD and MS (specification, p. 11 and 13)."""
    bare, note = command.split(b";")
    *before, last = answers_of([command], turns=4)
    scans = [*before, last] if bare.startswith(b"G") else [*before[1:], last]
    left = [] if bare.startswith(b"G") else [b"01", b"00"]
    assert [echo for echo, *_ in scans] == [bare[:13] + remaining + b";" + note for remaining in left or [b""]]
    assert all(is_right(command, line) for _, *lines in scans for line in lines)


def test_the_decoder_refuses_any_other_sum() -> None:
    """The sum of a ``KEY:value;`` line may leave the last semicolon out, as some sensors do; that of data may not."""
    data, entry = b"0Ab;", b"SCAN:600;"
    with_all = {text: text + bytes([(sum(text) & 63) + 48]) for text in (data, entry)}
    without = {text: text + bytes([(sum(text[:-1]) & 63) + 48]) for text in (data, entry)}
    assert check_sum(with_all[data]) == data
    with pytest.raises(DecodeError):
        check_sum(without[data])
    assert check_sum(with_all[entry], entry=True) == check_sum(without[entry], entry=True) == entry
    assert decode_reply((b"PP", b"00P", with_all[entry])).lines == (entry,)
    assert Reply("PP", "00", (entry,)).encode() == b"PP\n00P\n" + without[entry] + b"\n\n"
