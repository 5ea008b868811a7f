"""The codecs refuse values and bytes that do not form a message, with DecodeError."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from hardware import DecodeError
from hardware.arcos.encoder_packet import WheelTravel
from hardware.arcos.packet import MAX_DATA, PacketDecoder, encode_packet
from hardware.ldrobot import SIZE, LdPacket
from hardware.scip.encoding import check_sum
from hardware.scip.frames import FrameDecoder
from hardware.scip.information import SensorParameters
from hardware.scip.status import status_meaning
from hardware.scip.time_stamp import decode_hex_time, decode_time

PACKET = LdPacket(10.0, 0.1, 0.3, np.ones(12), (200,) * 12, 1.0)
PARAMETERS = SensorParameters("URG-04LX", 0.02, 5.6, 1024, 44, 725, 384, 0.1)


@pytest.mark.parametrize("decode", [
    lambda: decode_time(b"000"),
    lambda: decode_hex_time("12G4"),
    lambda: check_sum(b""),
    lambda: WheelTravel.decode(b"\x00" * 9, 128000.0),
    lambda: LdPacket.decode(b"\x54\x2c"),
    lambda: LdPacket.decode(replace(PACKET, last=PACKET.first + 3.2).encode()),
    lambda: SensorParameters.decode(replace(PARAMETERS, first=800).encode()),
])  # fmt: skip
def test_values_that_do_not_fit_a_message_are_refused(decode: Callable[[], object]) -> None:
    with pytest.raises(DecodeError):
        decode()


def test_complete_messages_are_read_back() -> None:
    assert LdPacket.decode(PACKET.encode()).last == pytest.approx(PACKET.last, abs=1e-4)
    assert len(PACKET.encode()) == SIZE
    assert SensorParameters.decode(PARAMETERS.encode()) == PARAMETERS
    assert status_meaning("MD", "00") == "done"


@pytest.mark.parametrize("size", [0, MAX_DATA + 1])
def test_a_packet_length_is_limited(size: int) -> None:
    with pytest.raises(ValueError, match="holds 1 to"):
        encode_packet(b"\x01" * size)


def test_the_largest_packet_is_decoded() -> None:
    assert PacketDecoder().feed(encode_packet(b"\x01" * MAX_DATA)) == [b"\x01" * MAX_DATA]


def test_endless_garbage_is_not_buffered() -> None:
    decoder = FrameDecoder()
    assert decoder.feed(b"x" * 100_000) == []
    ((first, status),) = decoder.feed(b"\n00P\n\n")
    assert len(first) < 10_000
    assert status == b"00P"
