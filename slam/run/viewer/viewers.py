"""``--rerun``: the places where a run is shown, and their viewers; without any, rerun is not imported."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from shutil import copyfile
from typing import TYPE_CHECKING, Final, Literal
from urllib.parse import urlsplit

from slam.closing import Closing
from slam.console.terminal import Terminal
from slam.errors import InputError
from slam.run.viewer import rerun_program
from slam.scenario.settings import one_or_several

if TYPE_CHECKING:
    from slam.run.viewer.broadcast import Broadcast
    from slam.run.viewer.scene import Scene

GRPC_PORT: Final = 9876
WEB_PORT: Final = 9090
FORMS: Final = "FILE.rrd, spawn, connect[=URL] or serve[=PORT]"
NO_DISPLAY: Final = (
    "--rerun spawn: there is no screen here; use --rerun serve and a browser, --rerun connect=HOST to a viewer "
    "elsewhere, or --rerun FILE.rrd"
)
_QUIET: Final = "warn,re_grpc_client=off,re_sdk::recording_stream=off"
"""Log levels of rerun: this program itself reports, in one line, that a viewer has gone."""


@dataclass(frozen=True, slots=True)
class Target:
    """One place to show a run."""

    kind: Literal["file", "spawn", "connect", "serve"]
    path: Path = Path()
    """Path of a file."""
    url: str = f"rerun+http://127.0.0.1:{GRPC_PORT}/proxy"
    """Address of a viewer to connect to."""
    port: int = WEB_PORT
    """Port of the served web page; the data is served at the next port."""


def parse_targets(given: str | Iterable[str]) -> list[Target]:
    """Parse all options, each target once; InputError for another form, or a file that cannot be written."""
    return list(dict.fromkeys(map(parse_target, one_or_several(given))))


def parse_target(text: str) -> Target:
    """Parse one option; InputError for another form, or a file that cannot be written."""
    kind, _, value = text.partition("=")
    if text == "spawn":
        return Target("spawn")
    if kind == "connect":
        return Target("connect", url=_url(value, text)) if value else Target("connect")
    if kind == "serve":
        return Target("serve", port=_port(value, text)) if value else Target("serve")
    return Target("file", path=_file(Path(text)))


def _url(value: str, text: str) -> str:
    """Return an address in rerun's form, from HOST or HOST:PORT too."""
    address = urlsplit(value if "://" in value else f"rerun+http://{value}")
    try:
        host, port = address.hostname, address.port or GRPC_PORT
    except ValueError as error:
        raise InputError(f"--rerun {text}: {error}; give HOST:PORT") from error
    if not host or address.scheme not in ("rerun", "rerun+http", "rerun+https"):
        raise InputError(f"--rerun {text}: no address of a viewer; give HOST:PORT, or rerun+http://HOST:PORT/proxy")
    host = f"[{host}]" if ":" in host else host
    return f"{address.scheme}://{host}:{port}{address.path if address.path.strip('/') else '/proxy'}"


def _port(value: str, text: str) -> int:
    if not value.isdecimal() or not 1024 <= int(value) <= 65534:
        raise InputError(f"--rerun {text}: no port of a web page; give serve=PORT, from 1024 to 65534")
    return int(value)


def _file(path: Path) -> Path:
    if path.suffix != ".rrd":
        raise InputError(f"--rerun {path}: give {FORMS}; a recording needs a name that ends in .rrd")
    try:
        path.open("ab").close()
    except OSError as error:
        raise InputError(f"--rerun {path}: cannot be written: {error.strerror}; choose another FILE.rrd") from error
    return path.resolve()


class Viewers(Closing):
    """All targets of ``--rerun``. Closing ends the servers; a viewer's window stays open."""

    def __init__(self, targets: str | Iterable[str] = (), console: Terminal | None = None) -> None:
        self._targets = parse_targets(targets)
        self._console = console or Terminal(quiet=True)
        self._urls: list[str] | None = None
        self._servers: list[tuple[str, subprocess.Popen[bytes]]] = []

    def start(self) -> None:
        """Start windows and servers, before anything of a run is written; InputError if one cannot be started."""
        if self._urls is None:
            self._urls = list(dict.fromkeys(url for target in self._targets if (url := self._url(target))))

    def open(self, scene: Scene, folder: Path | None = None) -> Broadcast | None:
        """Start all viewers that are not running yet; None without a target.

        If a target is a file, the run's folder gets a recording too.
        """
        if not self._targets:
            return None
        os.environ.setdefault("RUST_LOG", _QUIET)  # rerun reads it when it is imported
        from slam.run.viewer.broadcast import Broadcast

        files = [target.path for target in self._targets if target.kind == "file"]
        if files and folder is not None:
            files.append((folder / "run.rrd").resolve())
        self.start()
        return Broadcast(files, self._urls or [], scene, self.say)

    def open_file(self, recording: Path) -> None:
        """Show a complete recording."""
        for target in self._targets:
            if target.kind == "file":
                if target.path != recording.resolve():
                    copyfile(recording, target.path)
                self.say(f"recording in {target.path}")
            elif target.kind == "connect":
                self._send_file(recording, target.url)
            elif target.kind == "spawn":
                self._spawned(recording)
            else:
                self._served(target.port, recording)

    def say(self, text: str) -> None:
        """Print one line for the user."""
        self._console.print(text)

    def serve_until_interrupted(self) -> None:
        """If a page is served, wait for Ctrl-C."""
        for address, server in self._servers:
            self.say(f"still served: {address}\nCtrl-C ends it")
            with suppress(KeyboardInterrupt):
                server.wait()

    def _url(self, target: Target) -> str | None:
        """Start the viewer and return its address; None for a file, and if there cannot be one."""
        if target.kind == "file":
            return None
        if target.kind == "spawn":
            return self._spawned()
        return self._served(target.port) if target.kind == "serve" else target.url

    def _spawned(self, *files: Path) -> str | None:
        url = rerun_program.data_address(GRPC_PORT)
        if not files and rerun_program.is_listening(url):
            return url
        if not rerun_program.has_display():
            self.say(NO_DISPLAY)
            return None
        rerun_program.spawn_viewer("auto" if files else str(GRPC_PORT), *files)
        return url

    def _served(self, port: int, *files: Path) -> str:
        self._servers.append((rerun_program.page_address(port), rerun_program.serve_page(port, *files)))
        self.say(f"viewer: {rerun_program.page_address(port)}")
        return rerun_program.data_address(port + 1)

    def _send_file(self, recording: Path, url: str) -> None:
        from slam.run.viewer.broadcast import send_file

        if not rerun_program.is_listening(url):
            raise InputError(f"--rerun connect: no viewer at {url}; start one there with: rerun")
        send_file(recording, url)
        self.say(f"sent to {url}")

    def close(self) -> None:
        """End the servers."""
        for _, server in self._servers:
            rerun_program.stop_server(server)
