"""The rerun program: a viewer's window, or a server of the viewer's web page; and checks of addresses."""

import os
import socket
import subprocess
import sys
from collections.abc import Sequence
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path
from time import monotonic, sleep
from typing import Final
from urllib.parse import quote, urlsplit

from slam.errors import InputError

_START: Final = 15.0
"""Seconds for a program to begin to listen."""
_MEMORY: Final = "512MB"
"""Memory of a server for viewers that connect late; the oldest data is dropped first."""

_UNTIL_PARENT_ENDS: Final = 'exec 3<&0; "$@" & program=$!; (cat <&3 >/dev/null; kill $program) & wait $program'
"""Shell command that ends a program when its standard input, a pipe of this process, is closed, even by kill -9."""


def has_display() -> bool:
    """Return True if there is a screen for a window."""
    return sys.platform != "linux" or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def spawn_viewer(port: str, *files: Path) -> subprocess.Popen[bytes]:
    """Start a viewer's window, which stays open when this program ends.

    It receives data at this port of the loopback interface; with ``auto`` it chooses the port.
    """
    return _start(_command("--port", port, "--bind", "127.0.0.1", *map(str, files)), subprocess.DEVNULL)


def serve_page(port: int, *files: Path) -> subprocess.Popen[bytes]:
    """Start a server of the web page at the port, and of the data at the next, both on the loopback interface only.

    InputError if a port is taken, or nothing is served in time.
    """
    for number in (port, port + 1):
        if not is_port_free(number):
            raise InputError(f"--rerun serve={port}: port {number} is taken; give another with --rerun serve=PORT")
    ports = ("--web-viewer-port", str(port), "--port", str(port + 1))
    options = ("--serve-web", "--bind", "127.0.0.1", *ports, "--server-memory-limit", _MEMORY)
    program = _start_bound(_command(*options, *map(str, files)))
    until = monotonic() + _START
    while not (is_listening(page_address(port)) and (files or is_listening(data_address(port + 1)))):
        if program.poll() is not None or monotonic() > until:
            stop_server(program)
            raise InputError(f"--rerun serve={port}: rerun does not serve; give another port, or --rerun FILE.rrd")
        sleep(0.05)
    return program


def page_address(port: int) -> str:
    """URL to open in a browser."""
    return f"http://127.0.0.1:{port}/?url={quote(data_address(port + 1), safe='')}"


def data_address(port: int) -> str:
    """URL at which data is received and served on this machine."""
    return f"rerun+http://127.0.0.1:{port}/proxy"


def stop_server(server: subprocess.Popen[bytes]) -> None:
    """End a server of ``serve_page``, and wait until it has ended."""
    if server.stdin is not None:
        server.stdin.close()
    if sys.platform == "win32":
        server.terminate()
    server.wait()


def _command(*arguments: str) -> list[str]:
    spec = find_spec("rerun_cli")
    if spec is None or spec.origin is None:
        raise InputError("the rerun program is not installed; run: pip install rerun-sdk")
    program = Path(spec.origin).with_name("rerun.exe" if sys.platform == "win32" else "rerun")
    return [str(program), *arguments]


def _start_bound(command: Sequence[str]) -> subprocess.Popen[bytes]:
    """Start a program that ends with this process in any case."""
    bound = command if sys.platform == "win32" else ["/bin/sh", "-c", _UNTIL_PARENT_ENDS, "sh", *command]
    return _start(bound, subprocess.PIPE)


def _start(command: Sequence[str], stdin: int) -> subprocess.Popen[bytes]:
    """Start the program in its own session, so that Ctrl-C does not reach it, and without its telemetry."""
    silent = subprocess.DEVNULL
    group = getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0)  # Windows has no sessions
    return subprocess.Popen(
        command, stdin=stdin, stdout=silent, stderr=silent, start_new_session=True, creationflags=group,
        env=_without_telemetry(),
    )  # fmt: skip


def _without_telemetry() -> dict[str, str]:
    """Return an environment in which rerun sends no usage data, and writes no file about that in the user's home.

    Rerun sends nothing if CI is set, unless FORCE_RERUN_ANALYTICS is.
    """
    return {"CI": "true", **os.environ}


def is_listening(url: str) -> bool:
    """Return True if a program accepts connections at the host and port of this address."""
    place = urlsplit(url)
    with suppress(OSError), socket.create_connection((place.hostname, place.port or 80), timeout=0.5):
        return True
    return False


def is_port_free(port: int) -> bool:
    """Return True if this port of the loopback interface is free."""
    with suppress(OSError), socket.create_server(("127.0.0.1", port)):
        return True
    return False
