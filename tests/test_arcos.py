"""ARCOS: laws of the codec, then bytes that real clients sent."""

from dataclasses import fields, replace
from itertools import pairwise
from math import pi, radians

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from hardware import DecodeError
from hardware.arcos.commands import Command, CommandId, decode_vel2, encode_vel2
from hardware.arcos.config_packet import ArcosConfig
from hardware.arcos.encoder_packet import WheelTravel, travel_wrap
from hardware.arcos.io_packet import IoReport
from hardware.arcos.model import P3DX, P3DX_SH, Identity, units_of
from hardware.arcos.packet import MAX_DATA, PacketDecoder, checksum, encode_packet
from hardware.arcos.sip import Sip
from hardware.base_odometry import unwrapped_step
from tests.fuzz_codecs import fuzz_arcos

DATA = st.binary(min_size=1, max_size=MAX_DATA)
NOISE = st.binary(max_size=30).filter(lambda noise: 0xFA not in noise)


def cut(stream: bytes, cuts: list[int]) -> list[bytes]:
    """Cut the stream at these positions, which are taken modulo its length."""
    ends = sorted({c % (len(stream) + 1) for c in cuts} | {0, len(stream)})
    return [stream[a:b] for a, b in pairwise(ends)]


@given(st.lists(st.tuples(NOISE, DATA), max_size=5), st.lists(st.integers(0, 5000)))
def test_packets_are_decoded_between_noise_and_splits(parts: list[tuple[bytes, bytes]], cuts: list[int]) -> None:
    stream = b"".join(noise + encode_packet(data) for noise, data in parts)
    decoder = PacketDecoder()
    found = [data for piece in cut(stream, cuts) for data in decoder.feed(piece)]
    assert found == [data for _, data in parts]
    assert not decoder.pending


@given(st.lists(DATA, min_size=3, max_size=6), st.integers(0, 10_000), st.integers(1, 255))
def test_one_damaged_byte_loses_one_packet(packets: list[bytes], place: int, flip: int) -> None:
    stream = bytearray(b"".join(map(encode_packet, packets)))
    victim = place % len(packets)
    start = sum(len(data) + 5 for data in packets[:victim])
    stream[start + place % (len(packets[victim]) + 5)] ^= flip
    decoder = PacketDecoder()
    found = decoder.feed(bytes(stream)) + decoder.flush()
    assert not decoder.pending
    rest = packets[:victim] + packets[victim + 1 :]
    assert [data for data in found if data in rest] == rest


def test_a_second_header_byte_does_not_hide_the_packet() -> None:
    assert PacketDecoder().feed(b"\xfa" + encode_packet(b"\x00")) == [b"\x00"]


@given(st.binary(max_size=2000))
def test_the_decoder_holds_less_than_a_packet(noise: bytes) -> None:
    decoder = PacketDecoder()
    for start in range(0, len(noise), 7):
        decoder.feed(noise[start : start + 7])
        assert len(decoder._buffer) < 200


def test_a_burst_of_headers_is_skipped() -> None:
    decoder = PacketDecoder()
    assert decoder.feed(b"\xfa\xfb" * 20_000 + encode_packet(b"\x00")) == [b"\x00"]
    assert not decoder.pending


def test_random_bytes_do_not_break_the_decoder() -> None:
    fuzz_arcos(200_000, seed=1)


ARGUMENTS = st.none() | st.integers(-65535, 65535) | st.binary(max_size=190)


@given(st.integers(0, 255), ARGUMENTS)
def test_a_command_is_decoded_as_encoded(id: int, argument: int | bytes | None) -> None:
    command = Command(id, argument)
    assert Command.decode(command.encode()) == command


@pytest.mark.parametrize(
    ("wire", "command"),
    [
        ("FA FB 03 00 00 00", Command(0)),
        ("FA FB 06 01 3B 01 00 02 3B", Command(CommandId.OPEN, 1)),
        ("FA FB 06 04 3B 01 00 05 3B", Command(CommandId.ENABLE, 1)),
        ("FA FB 06 0B 3B FA 00 05 3B", Command.of(CommandId.VEL, 0.25)),
        ("FA FB 06 0B 1B 96 00 A1 1B", Command.of(CommandId.VEL, -0.15)),
        ("FA FB 06 15 1B 19 00 2E 1B", Command.of(CommandId.RVEL, radians(-25))),
        ("FA FB 06 05 1B 2C 01 31 1C", Command.of(CommandId.SETA, -0.3)),
        ("FA FB 06 20 3B 05 0F 25 4A", encode_vel2(0.3, 0.1)),
        ("FA FB 06 20 1B F6 09 16 24", encode_vel2(-0.2, 0.2)),
        ("FA FB 06 20 3B F6 0A 16 45", encode_vel2(0.2, -0.2)),
        ("FA FB 06 20 1B 05 0E 25 29", encode_vel2(-0.3, -0.1)),
        ("FA FB 06 0C 3B 15 00 21 3B", Command.of(CommandId.HEAD, radians(21))),
        ("FA FB 06 08 1B 64 00 6C 1B", Command.of(CommandId.MOVE, -0.1)),
        ("FA FB 06 1C 3B 00 00 1C 3B", Command(CommandId.SONAR, 0)),
    ],
)
def test_recorded_bytes_are_decoded(wire: str, command: Command) -> None:
    packet = bytes.fromhex(wire)
    assert encode_packet(command.encode()) == packet
    assert [Command.decode(data) for data in PacketDecoder().feed(packet)] == [command]


def test_rare_forms_of_commands_are_decoded() -> None:
    assert Command.decode(bytes.fromhex("0F 2B 02 61 62 00")) == Command(CommandId.SAY, b"ab")
    (cut_off,) = PacketDecoder().feed(bytes.fromhex("FA FB 04 07 3B 07 3B"))  # Player's SETO
    assert Command.decode(cut_off) == Command(CommandId.SETO)
    with pytest.raises(DecodeError):
        Command.decode(bytes.fromhex("0B 77 01 00"))
    with pytest.raises(DecodeError):
        _ = Command(CommandId.PULSE).quantity


@given(st.integers(-128, 127), st.integers(-128, 127))
@example(-128, 0)
def test_vel2_of_aria_and_of_player_is_decoded(left: int, right: int) -> None:
    speeds = pytest.approx((0.02 * left, 0.02 * right))
    argument = encode_vel2(0.02 * left, 0.02 * right).argument
    assert isinstance(argument, int)
    assert -0x8000 <= argument < 0x8000
    assert decode_vel2(argument) == speeds
    assert decode_vel2((left & 0xFF) << 8 | (right & 0xFF)) == speeds


def test_checksums_of_odd_and_even_lengths_are_right() -> None:
    assert checksum(bytes([1])) == 1
    assert checksum(bytes([0x0B, 0x3B, 0xFA, 0x00])) == 0x053B


SIP = Sip(
    moving=True,
    x=1.234,
    y=32.0,
    theta=-100 * 2 * pi / 4096,
    left=0.3,
    right=-0.2,
    battery=12.6,
    left_contacts=0b101,
    right_contacts=0b10,
    flags=33,
    sonar=((0, 1.5), (7, 5.0)),
    digital_in=3,
)
TAIL = {
    "fine_battery": 12.7,
    "charge_state": 1,
    "turning": radians(-12.3),
    "faults": 2,
    "lateral": 0.0,
    "temperature": -5,
    "charge": 80,
    "time": 12.5,
    "flags3": 7,
}


def approximately(sip: Sip) -> dict[str, object]:
    values = {f.name: getattr(sip, f.name) for f in fields(sip)}
    return {k: pytest.approx(v, abs=1e-9) if isinstance(v, float) else v for k, v in values.items()}


@pytest.mark.parametrize("length", range(len(TAIL) + 1))
def test_a_sip_of_every_length_is_decoded_as_encoded(length: int) -> None:
    sip = replace(SIP, **dict(list(TAIL.items())[:length]))
    decoded = Sip.decode(sip.encode(P3DX_SH), P3DX_SH)
    assert {f.name: getattr(decoded, f.name) for f in fields(decoded)} == approximately(sip)


def test_values_beyond_the_fields_of_a_sip_are_clipped() -> None:
    """Speeds have 16 bits with a sign, the battery has eight without; positions wrap around instead."""
    for units in (P3DX, P3DX_SH):
        sip = Sip.decode(Sip(left=1e3, right=-1e3, battery=1e3, x=-0.5, y=-0.5).encode(units), units)
        assert (sip.left, sip.right) == pytest.approx((32767 * units.speed, -32768 * units.speed))
        assert sip.battery == pytest.approx(25.5)
        assert 0.0 <= sip.x < units.wrap
        assert sip.y == sip.x


def test_a_sip_has_its_fields() -> None:
    sip = Sip.decode(SIP.encode(P3DX_SH), P3DX_SH)
    assert (sip.stalled, sip.front_bumpers, sip.rear_bumpers) == (True, 1, 2)
    assert (sip.motors_enabled, sip.e_stop) == (True, True)
    with pytest.raises(DecodeError):
        Sip.decode(SIP.encode(P3DX_SH)[:20], P3DX_SH)
    with pytest.raises(DecodeError):
        Sip.decode(b"\x20" * 50, P3DX_SH)


@given(st.floats(-1e3, 1e3), st.floats(-5, 5), st.sampled_from([P3DX, P3DX_SH]))
def test_wrapped_odometry_is_unwrapped(start: float, step: float, units: type) -> None:
    before, after = (Sip.decode(Sip(x=x).encode(units), units).x for x in (start, start + step))
    assert unwrapped_step(before, after, units.wrap) == pytest.approx(step, abs=1.01 * units.distance)


@given(st.floats(-1e6, 1e6), st.floats(-100, 100))
def test_wrapped_encoders_are_unwrapped(start: float, step: float) -> None:
    ways = [WheelTravel.decode(WheelTravel(x, -x).encode(128e3), 128e3) for x in (start, start + step)]
    assert unwrapped_step(ways[0].left, ways[1].left, travel_wrap(128e3)) == pytest.approx(step, abs=2e-5)
    assert unwrapped_step(ways[0].right, ways[1].right, travel_wrap(128e3)) == pytest.approx(-step, abs=2e-5)


def test_encoders_count_32_bits() -> None:
    assert travel_wrap(128e3) == pytest.approx(2**32 / 128e3)


def test_the_io_report_has_the_layout_of_the_manual() -> None:
    """Pioneer 3 Operations Manual, p. 41: for each kind of input, the number of bytes and then the bytes."""
    report = IoReport(1, 2, 3, 4, 5, (1023, 256))
    assert report.encode() == bytes.fromhex("F0 04 01 02 03 04 01 05 02 FF 03 00 01")


def test_the_last_byte_of_a_configuration_is_read() -> None:
    data = ArcosConfig(kinematics_delay=0.05).encode()
    assert ArcosConfig.decode(data).kinematics_delay == pytest.approx(0.05)
    assert ArcosConfig.decode(data[:-1]).kinematics_delay == 0.0


def test_a_configuration_may_end_early() -> None:
    config = ArcosConfig(name="robot", watchdog=2.0, sip_cycle=0.1, ticks_per_metre=128e3, max_angular=radians(300))
    data = config.encode()
    assert len(data) <= MAX_DATA
    decoded = ArcosConfig.decode(data)
    assert (decoded.name, decoded.watchdog, decoded.sip_cycle, decoded.ticks_per_metre) == ("robot", 2.0, 0.1, 128e3)
    assert decoded.max_angular == pytest.approx(radians(300))
    assert ArcosConfig.decode(data[:60]).ticks_per_metre == 0.0
    for end in range(1, len(data)):
        ArcosConfig.decode(data[:end])


def test_the_identity_of_the_robot_is_decoded() -> None:
    wire = bytes.fromhex("FA FB 19 02") + b"Emu_P3DX\0Pioneer\0p3dx\0" + bytes.fromhex("C6 35")
    (data,) = PacketDecoder().feed(wire)
    identity = Identity.decode(data)
    assert identity == Identity("Emu_P3DX", "Pioneer", "p3dx")
    assert encode_packet(identity.encode()) == wire


def test_the_subclass_decides_the_units() -> None:
    assert units_of("p3dx") is P3DX
    assert units_of("P3DX-SH") is P3DX_SH
    assert units_of("powerbot") is None
