"""Random and mutated bytes into every decoder: ``python -m tests.fuzz_codecs [BYTES]`` from the top of the tree.

Whatever the bytes, a decoder may raise only ``DecodeError``, and the data that it keeps stay below its bound.
"""

import gc
import random
import sys
import time
import tracemalloc
from collections.abc import Callable
from contextlib import suppress

import numpy as np

from hardware import DecodeError
from hardware.arcos.commands import Command, CommandId
from hardware.arcos.config_packet import ArcosConfig
from hardware.arcos.encoder_packet import WheelTravel
from hardware.arcos.model import P3DX, Identity
from hardware.arcos.packet import PacketDecoder, encode_packet
from hardware.arcos.sip import Sip
from hardware.scip.commands import ScanRequest
from hardware.scip.frames import CommandDecoder, FrameDecoder
from hardware.scip.information import SensorParameters, SensorState, VersionInfo
from hardware.scip.reply import Reply, decode_old_reply, find_reply
from hardware.scip.scan_data import ScanData, decode_scan, encode_scan

PARAMETERS = SensorParameters("URG-04LX", 0.02, 5.6, 1024, 44, 725, 384, 0.1)


def arcos_seeds() -> list[bytes]:
    """One valid packet of each kind."""
    sip = Sip(sonar=((0, 1.0),), fine_battery=12.0, charge_state=0, turning=0.0)
    commands = [Command(CommandId.PULSE), Command(CommandId.VEL, -5), Command(CommandId.SAY, b"ab")]
    data = [sip.encode(P3DX), ArcosConfig(name="a").encode(), WheelTravel(1.0, 2.0).encode(1e5)]
    return [encode_packet(d) for d in [*data, Identity("a", "b", "c").encode(), *(c.encode() for c in commands)]]


def scip_seeds() -> list[bytes]:
    """One valid answer of each kind, and a few commands."""
    scan = ScanData(ScanRequest("MD", 44, 83), np.linspace(0.0, 5.0, 40), 1.0)
    old = Reply(
        "V", "0", VersionInfo("a", "b", "c(20-4095[mm],240[deg],44-725[step],600[rpm])", "d", "e").encode("V").lines
    )
    replies = [
        VersionInfo("a", "b", "c", "d", "e").encode(),
        PARAMETERS.encode(),
        SensorState("a", True, "b", "c", "d", 1.0, "e").encode(),
        encode_scan(scan, "99"),
        old,
        Reply("SCIP2.0", "0"),
        Reply("BM", "02"),
    ]
    return [reply.encode() for reply in replies] + [b"MD0044072501000\n", b"G04472501\r\n"]


def noise(seeds: list[bytes], rng: random.Random) -> bytes:
    """Random bytes, or a valid message in which some bytes were changed, dropped or doubled."""
    if rng.random() < 0.2:
        return rng.randbytes(rng.randrange(1, 300))
    message = bytearray(rng.choice(seeds))
    for _ in range(rng.randrange(4)):
        at = rng.randrange(len(message))
        message[at : at + 1] = rng.choice([rng.randbytes(1), b"", bytes(message[at : at + 1]) * 2])
        message = message or bytearray(b"\n")
    return bytes(message)


def try_arcos(data: bytes) -> None:
    """Give the data of a packet to every function that reads one."""
    readers: list[Callable[[], object]] = [
        lambda: Command.decode(data),
        lambda: Command.decode(data).quantity,
        lambda: Sip.decode(data, P3DX),
        lambda: Sip.decode(b"\x32" + data, P3DX),
        lambda: ArcosConfig.decode(b"\x20" + data),
        lambda: WheelTravel.decode(b"\x90" + data, 1e5),
        lambda: Identity.decode(b"\x02" + data),
    ]
    for read in readers:
        with suppress(DecodeError):
            read()


def try_scip(lines: tuple[bytes, ...]) -> None:
    """Give the lines of an answer to every function that reads one."""
    replies = [find_reply(lines)]
    with suppress(DecodeError):
        replies.append(decode_old_reply(lines))
    for reply in filter(None, replies):
        for read in (
            decode_scan,
            VersionInfo.decode,
            SensorParameters.decode,
            SensorState.decode,
        ):
            with suppress(DecodeError):
                read(reply)


def fuzz_arcos(size: int, seed: int) -> int:
    """Feed ``size`` bytes; return the number of packets found."""
    rng, decoder, seeds = random.Random(seed), PacketDecoder(), arcos_seeds()
    done = found = 0
    while done < size:
        piece = noise(seeds, rng)
        done += len(piece)
        for data in decoder.feed(piece):
            found += 1
            try_arcos(data)
        try_arcos(piece)
        assert len(decoder._buffer) < 200
        if not rng.randrange(10):
            decoder.flush()
    return found


def fuzz_scip(size: int, seed: int) -> int:
    """Feed ``size`` bytes; return the number of answers found."""
    rng, frames, commands, seeds, done, found = (
        random.Random(seed),
        FrameDecoder(),
        CommandDecoder(),
        scip_seeds(),
        0,
        0,
    )
    while done < size:
        piece = noise(seeds, rng)
        done += len(piece)
        for lines in frames.feed(piece):
            found += 1
            try_scip(lines)
        for text in commands.feed(piece):
            with suppress(DecodeError):
                ScanRequest.decode(text)
        assert len(frames._buffer) <= 8192
        assert len(commands._buffer) <= 8192
    return found


def main() -> None:
    """Feed both decoders, and print by how much the memory grew."""
    size = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000_000
    for fuzz in (fuzz_arcos, fuzz_scip):
        fuzz(20_000, seed=0)
        tracemalloc.start()
        began, before = time.perf_counter(), tracemalloc.get_traced_memory()[0]
        found = fuzz(size, seed=1)
        gc.collect()
        grown = tracemalloc.get_traced_memory()[0] - before
        tracemalloc.stop()
        seconds = time.perf_counter() - began
        print(f"{fuzz.__name__}: {size} bytes, {found} messages, {seconds:.0f} s, memory grew by {grown} bytes")


if __name__ == "__main__":
    main()
