"""SCIP: laws of the codec, then the bytes of the specification and of a real sensor."""

import ast
import random
from itertools import pairwise
from math import radians
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hardware import DecodeError
from hardware.scip.commands import ScanRequest, echo_at_end, set_baud
from hardware.scip.encoding import add_sum, check_sum, decode_values, encode_values
from hardware.scip.frames import CommandDecoder, FrameDecoder
from hardware.scip.information import SensorParameters, SensorState, VersionInfo
from hardware.scip.reply import Reply, decode_old_reply, decode_reply, find_reply
from hardware.scip.scan_data import ScanData, decode_scan, decode_time, encode_scan, encode_time
from hardware.scip.status import is_ok, status_meaning
from slam.lidars import URG04LX
from tests.fuzz_codecs import fuzz_scip

REAL = Path(__file__).parents[2] / "shared" / "data" / "real_urg04lx_hokuyoaist.txt"
FULL = ScanRequest("MD", 44, 725, 1, 0, 99)


def scan_bytes(seed: int, request: ScanRequest = FULL) -> bytes:
    """A whole answer with ranges from this seed, in which a twentieth are errors."""
    rng = np.random.default_rng(seed)
    ranges = np.round(rng.uniform(0.02, 5.6, request.values), 3)
    ranges[rng.random(len(ranges)) < 0.05] = np.inf
    return encode_scan(ScanData(request, ranges, seed / 1000.0), "99").encode()


@given(st.integers(2, 4).flatmap(lambda w: st.tuples(st.just(w), st.lists(st.integers(0, 64**w - 1), max_size=50))))
def test_values_are_decoded_as_encoded(case: tuple[int, list[int]]) -> None:
    width, values = case
    text = encode_values(np.array(values, np.int64), width)
    assert len(text) == width * len(values)
    assert decode_values(text, width).tolist() == values


def test_values_of_the_specification_are_encoded() -> None:
    assert decode_values(b"CB", 2).tolist() == [1234]
    assert decode_values(b"1Dh", 3).tolist() == [5432]
    assert decode_values(b"m2@0", 4).tolist() == [16_000_000]
    for text, width in ((b"abc", 2), (b"\x2f0", 2), (b"p0", 2)):
        with pytest.raises(DecodeError):
            decode_values(text, width)
    with pytest.raises(ValueError, match="2 characters hold 0 to 4095"):
        encode_values(np.array([4096]), 2)


@given(st.binary(min_size=1, max_size=64))
def test_a_line_is_decoded_as_encoded(line: bytes) -> None:
    assert check_sum(add_sum(line)) == line
    assert check_sum(add_sum(line, entry=True), entry=True) == line


@pytest.mark.parametrize("line", [b"00P", b"02R", b"03S", b"99b", b"0Ee", b"JUGnD"])
def test_recorded_sums_are_right(line: bytes) -> None:
    assert check_sum(line) == line[:-1]
    assert add_sum(line[:-1]) == line


@pytest.mark.parametrize("entry", [b"SCAN:600;e", b"PROT:SCIP 2.0;N"])
def test_recorded_sums_of_entries_are_right(entry: bytes) -> None:
    assert check_sum(entry, entry=True) == entry[:-1]
    assert add_sum(entry[:-1], entry=True) == entry


STEP, TWO_DIGITS, DIGIT = st.integers(0, 768), st.integers(0, 99), st.integers(0, 9)


@given(st.sampled_from("DS"), st.tuples(STEP, STEP, TWO_DIGITS, DIGIT, TWO_DIGITS))
def test_measuring_commands_are_decoded_as_encoded(kind: str, numbers: tuple[int, int, int, int, int]) -> None:
    request = ScanRequest("M" + kind, *numbers)
    assert ScanRequest.decode(request.encode()) == request
    latest = ScanRequest("G" + kind, *numbers[:3])
    assert ScanRequest.decode(latest.encode() + ";a note") == latest


def test_commands_of_other_clients_are_decoded() -> None:
    assert ScanRequest("MD", 44, 725, 1, 0, 0).encode() == "MD0044072501000"
    assert ScanRequest("GD", 44, 725, 1).encode() == "GD0044072501"
    assert ScanRequest.decode("G00076801") == ScanRequest("G", 0, 768, 1)
    assert ScanRequest("G", 0, 768).encode() == "G00076801"
    assert ScanRequest("MD", 44, 725, 3).values == 228
    assert set_baud(115200) == "SS115200"
    for text in ("VV", "BM;x", "TM1", "SS019200", "CR00", "HS0", "SCIP2.0", "MS0044072501000"):
        assert echo_at_end(b"noise" + text.encode()) == text.encode()
    with pytest.raises(DecodeError):
        ScanRequest.decode("VV")


@given(st.lists(st.integers(0, 50), max_size=4), st.lists(st.integers(0, 9000), max_size=30))
def test_answers_are_decoded_however_they_are_split(seeds: list[int], cuts: list[int]) -> None:
    stream = b"\n\n".join([b"", *map(scan_bytes, seeds)])
    ends = sorted({c % (len(stream) + 1) for c in cuts} | {0, len(stream)})
    decoder = FrameDecoder()
    frames = [lines for a, b in pairwise(ends) for lines in decoder.feed(stream[a:b])]
    replies = list(map(find_reply, frames))
    assert [reply and reply.encode() for reply in replies] == list(map(scan_bytes, seeds))


def test_answers_are_decoded_byte_by_byte() -> None:
    decoder = FrameDecoder()
    frames = [lines for byte in scan_bytes(1) for lines in decoder.feed(bytes([byte]))]
    assert len(frames) == 1
    assert not decoder.pending


@given(st.integers(0, 2**32), st.binary(max_size=80).filter(lambda noise: b"\n\n" not in noise))
def test_damage_loses_only_the_damaged_answer(seed: int, noise: bytes) -> None:
    small = ScanRequest("MD", 300, 400)
    scans = [scan_bytes(seed % 1000 + k, small) for k in range(4)]
    rng = random.Random(seed)
    victim, at = rng.randrange(3), rng.randrange(len(scans[0]))
    damaged = [*scans]
    damaged[victim] = scans[victim][:at] + noise + scans[victim][at + rng.randrange(4) :]
    replies = [find_reply(lines) for lines in FrameDecoder().feed(b"".join(damaged))]
    found = {reply.encode() for reply in replies if reply}
    assert set(scans[:victim] + scans[victim + 1 :]) <= found


def accepted(stream: bytes) -> list[ScanData]:
    scans = []
    for lines in FrameDecoder().feed(stream):
        reply = find_reply(lines)
        if reply is not None and reply.lines:
            scans.append(decode_scan(reply))
    return scans


def test_every_damaged_byte_is_noticed_or_harmless() -> None:
    stream = scan_bytes(3, ScanRequest("MD", 300, 330))
    (sent,) = accepted(stream)
    for at in range(len(stream)):
        for flip in (1, 7, 0x20, 0x40, 0xFF):
            damaged = bytearray(stream)
            damaged[at] ^= flip
            for lines in FrameDecoder().feed(bytes(damaged)):
                reply = find_reply(lines)
                try:
                    scan = decode_scan(reply) if reply else None
                except DecodeError:
                    scan = None
                if scan is not None and scan.request.first == 300 and scan.request.cluster == 1:
                    assert np.array_equal(scan.ranges, sent.ranges)
                    assert scan.time == sent.time


def test_ranges_and_error_codes_are_separated() -> None:
    ranges = np.array([0.02, 5.6, np.inf, np.nan, 0.01, -np.inf])
    scan = ScanData(ScanRequest("GD", 100, 105), ranges, 16777.2)
    reply = encode_scan(scan, "00")
    decoded = decode_scan(decode_reply(tuple(reply.encode()[:-2].split(b"\n"))))
    assert np.array_equal(decoded.ranges, [0.02, 5.6, np.inf, np.nan, np.nan, np.inf], equal_nan=True)
    assert decoded.time == 16777.2
    assert decode_values(reply.lines[1], 3).tolist() == [20, 5600, 0, 7, 7, 0]
    short = encode_scan(ScanData(ScanRequest("GS", 1, 1), np.array([5.0]), 0.0), "00")
    assert np.isinf(decode_scan(short).ranges[0])


@pytest.mark.parametrize(
    ("code", "metres"), [(0, np.inf), (1, np.nan), (6, np.inf), (7, np.nan), (16, np.inf), (19, np.nan)]
)
def test_error_codes_are_described(code: int, metres: float) -> None:
    reply = Reply("GD0001000101", "00", (b"0000", encode_values(np.array([code]), 3)))
    assert np.array_equal(decode_scan(reply).ranges, [metres], equal_nan=True)


def test_the_clock_wraps() -> None:
    assert decode_time(encode_time(16777.216 + 0.005)) == 0.005
    assert decode_time(b"JUGn") == 0x6A55FE / 1000.0


def test_answers_of_scip_1_1_are_decoded() -> None:
    version = VersionInfo("a", "b", "3.1.04,08/02/07(20-4095[mm],240[deg],44-725[step],600[rpm])", "SCIP1.1", "d")
    wire = version.encode("V").encode()
    assert wire.startswith(b"V\n0\nVEND:a\n")
    (lines,) = FrameDecoder().feed(wire)
    assert VersionInfo.decode(decode_old_reply(lines)) == version
    scan = encode_scan(ScanData(ScanRequest("G", 44, 83), np.full(40, 1.5), None), "0")
    (lines,) = FrameDecoder().feed(scan.encode())
    assert decode_scan(decode_old_reply(lines)).ranges.tolist() == [1.5] * 40
    assert decode_reply((b"SCIP2.0", b"0")) == Reply("SCIP2.0", "0")


def test_commands_end_with_any_line_end() -> None:
    decoder = CommandDecoder()
    assert decoder.feed(b"VV\rPP\r\nI") == ["VV", "PP"]
    assert decoder.feed(b"I\n\xff\n") == ["II", "?"]


def test_statuses_are_described() -> None:
    assert is_ok("00")
    assert is_ok("99")
    assert status_meaning("BM", "02") == "the laser was on already"
    assert status_meaning("MD0044072501000", "04") == "the last step is beyond the sensor's"
    assert "fault" in status_meaning("MD0044072501000", "66")
    assert status_meaning("VV", "zz") == "no known meaning"


def test_random_bytes_do_not_break_the_decoder() -> None:
    fuzz_scip(200_000, seed=1)


@pytest.fixture(scope="module")
def real() -> dict[str, bytes]:
    """The answers of a real URG-04LX (firmware 3.1.04), by command."""
    if not REAL.is_file():
        pytest.skip(f"no recording of a real sensor at {REAL}")
    answers = [ast.literal_eval(line.split(maxsplit=3)[3]) for line in REAL.read_text().splitlines() if " < " in line]
    return {answer.split(b"\n")[0].decode(): answer for answer in answers}


def reply_of(answer: bytes) -> Reply:
    (lines,) = FrameDecoder().feed(answer)
    return decode_reply(lines)


def test_the_identity_of_a_real_sensor_is_decoded(real: dict[str, bytes]) -> None:
    version = VersionInfo.decode(reply_of(real["VV"]))
    assert (version.firmware, version.serial_number) == ("3.1.04(02/Aug./2007)", "H0706400")
    assert version.encode().encode() == real["VV"]
    parameters = SensorParameters.decode(reply_of(real["PP"]))
    assert parameters.encode().encode() == real["PP"]
    lidar = parameters.lidar
    assert (lidar.beams, lidar.angle_min) == (URG04LX.lidar.beams, pytest.approx(URG04LX.lidar.angle_min))
    assert lidar.angle_max == pytest.approx(radians(119.88), abs=1e-4)
    state = SensorState.decode(reply_of(real["II"]))
    assert state.laser
    assert state.encode().encode() == real["II"]
    assert (reply_of(real["BM"]).status, reply_of(real["CR00"]).status) == ("02", "03")


def test_a_scan_of_a_real_sensor_is_decoded(real: dict[str, bytes]) -> None:
    reply = reply_of(real["GD0044072501"])
    scan = decode_scan(reply)
    assert scan.time == 0x6A55FE / 1000.0
    assert len(scan.ranges) == 682
    assert np.isinf(scan.ranges).sum() == 94
    assert np.isnan(scan.ranges).sum() == 7
    assert decode_values(b"".join(reply.lines[1:]), 3)[0] == 6 * 64 + 8
    assert reply.encode() == real["GD0044072501"]
