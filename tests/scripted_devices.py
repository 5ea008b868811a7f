"""Devices on TCP whose bytes are written down from the protocols' descriptions, without the project's own codecs."""

import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

Serve = Callable[[socket.socket], None]


@contextmanager
def device(serve: Serve) -> Iterator[str]:
    """Serve one client after another, and yield the address."""

    def accept() -> None:
        with suppress(OSError):
            while True:
                client, _ = server.accept()
                client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                with client, suppress(OSError):
                    serve(client)

    with socket.create_server(("127.0.0.1", 0)) as server:
        threading.Thread(target=accept, daemon=True).start()
        yield f"socket://127.0.0.1:{server.getsockname()[1]}"
        server.shutdown(socket.SHUT_RDWR)


def scip(text: str) -> str:
    """Add SCIP's sum to a line (C-42-03320B, p. 9)."""
    return text + chr((sum(text.encode()) & 0x3F) + 0x30)


def entries(**values: str) -> str:
    """Lines of the form ``KEY:value;sum``, with the sum of the characters before the semicolon."""
    return "".join(f"{k}:{v};{scip(f'{k}:{v}')[-1]}\n" for k, v in values.items())


VERSION = entries(VEND="Hokuyo", PROD="URG-04LX", FIRM="3.1.04", PROT="SCIP 2.0", SERI="H1")
PARAMETERS = entries(
    MODL="URG-04LX", DMIN="20", DMAX="5600", ARES="1024", AMIN="44", AMAX="725", AFRT="384", SCAN="600"
)
LIDAR = {
    "VV": f"VV\n{scip('00')}\n{VERSION}\n",
    "PP": f"PP\n{scip('00')}\n{PARAMETERS}\n",
    **{command: f"{command}\n{scip('00')}\n\n" for command in ("QT", "BM", "MD0044072501000")},
}
"""Answers of a sensor of SCIP 2.0 by their commands."""


def lidar(answers: dict[str, str], unknown: str = "0E", scans: bool = True) -> Serve:
    """A SCIP sensor that answers known commands with these texts, and others with the status ``unknown``.

    If that is empty, it does not answer others at all. After MD it sends a scan of 1 m every 0.1 s.
    """

    def scan(stamp: int) -> bytes:
        time_text = "".join(chr((stamp >> shift & 0x3F) + 0x30) for shift in (18, 12, 6, 0))
        values = "0?X" * 682  # 1000 mm in three characters: 0, 15, 40
        lines = "".join(scip(values[i : i + 64]) + "\n" for i in range(0, len(values), 64))
        return f"MD0044072501000\n{scip('99')}\n{scip(time_text)}\n{lines}\n".encode()

    def serve(client: socket.socket) -> None:
        buffer, streaming, began = b"", False, time.monotonic()
        client.settimeout(0.1)
        while True:
            try:
                data = client.recv(4096)
                if not data:
                    return
                buffer += data
            except TimeoutError:
                if streaming and scans:
                    client.sendall(scan(round(1000 * (time.monotonic() - began))))
            while b"\n" in buffer:
                line, buffer = buffer.split(b"\n", 1)
                command = line.decode("latin-1")
                if command:
                    status = unknown if len(unknown) == 1 else scip(unknown)
                    refusal = f"{command}\n{status}\n\n" if unknown else ""
                    client.sendall(answers.get(command, refusal).encode("latin-1"))
                streaming = command.startswith("MD") or (streaming and command != "QT")

    return serve


def packet(data: bytes, wrong: int = 0) -> bytes:
    """An ARCOS packet, with a ``wrong`` amount added to its checksum (ArRobotPacket::calcCheckSum)."""
    total = 0
    for i in range(0, len(data) & ~1, 2):
        total = (total + (data[i] << 8 | data[i + 1])) & 0xFFFF
    total ^= data[-1] if len(data) & 1 else 0
    return b"\xfa\xfb" + bytes([len(data) + 2]) + data + ((total + wrong) & 0xFFFF).to_bytes(2, "big")


def sip(x: int = 0, left: int = 0, right: int = 0) -> bytes:
    """A standing robot's report: 12.6 V, motors without power; position and wheel speeds in the robot's own units."""
    body = b"".join(value.to_bytes(2, "little", signed=True) for value in (x, 0, 0, left, right))
    return packet(b"\x32" + body + bytes([126]) + bytes(2) + bytes(2) + bytes(2) + b"\0" + b"\0" + bytes(5))


def config(watchdog: int) -> bytes:
    """CONFIGpac up to its watchdog, ms (ArRobotConfigPacketReader::packetHandler)."""
    numbers = b"".join(value.to_bytes(2, "little") for value in (500, 2200, 600, 4000, 500))
    middle = bytes([100, 0, 0]) + bytes(2) + bytes(2) + bytes(1) + bytes(2) + bytes(2)
    return b"\x20Pioneer\0p3dx-sh\0S1\0\0" + numbers + b"name\0" + middle + watchdog.to_bytes(2, "little")


def robot(subclass: str = "p3dx-sh", on_config: bytes = b"", report: bytes | None = None) -> Serve:
    """An ARCOS robot that answers CONFIG with these bytes and reports every 0.1 s once it is open."""
    identity = packet(b"\x02name\0Pioneer\0" + subclass.encode() + b"\0")

    def serve(client: socket.socket) -> None:
        buffer, is_open = b"", False
        client.settimeout(0.1)
        while True:
            try:
                data = client.recv(4096)
                if not data:
                    return
                buffer += data
            except TimeoutError:
                if is_open:
                    client.sendall(report or sip())
            while len(buffer) > 2 and len(buffer) >= buffer[2] + 3:
                whole, buffer = buffer[: buffer[2] + 3], buffer[buffer[2] + 3 :]
                command = whole[3]
                if is_open:
                    is_open = command != 2
                    client.sendall(on_config if command == 18 else b"")
                elif command == 1 and len(whole) > 6:
                    is_open = True
                elif command in (0, 1, 2):
                    client.sendall(identity if command == 2 else whole)

    return serve
