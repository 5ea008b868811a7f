"""All viewers of one run; without any, nothing of rerun is even imported."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from shutil import copyfile
from typing import TYPE_CHECKING, Final

from slam.closing import Closing
from slam.console.terminal import Terminal
from slam.errors import InputError
from slam.run.viewer.rerun_program import is_listening
from slam.run.viewer.targets import GRPC_PORT, Target, parse_targets

if TYPE_CHECKING:
    from slam.run.viewer.broadcast import Broadcast
    from slam.run.viewer.scene import Scene

NO_DISPLAY: Final = (
    "--rerun spawn: there is no screen here; use --rerun serve and a browser, --rerun connect=HOST to a viewer "
    "elsewhere, or --rerun FILE.rrd"
)

_QUIET: Final = "warn,re_grpc_client=off,re_sdk::recording_stream=off"
"""Log levels of rerun: this program itself says, in one line, that a viewer has gone."""


class Viewers(Closing):
    """Everything that ``--rerun`` asks for. Closing ends the servers; a viewer's window stays."""

    def __init__(self, targets: str | Iterable[str] = (), console: Terminal | None = None) -> None:
        self._targets = parse_targets(targets)
        self._console = console or Terminal(quiet=True)
        self._servers: list[tuple[str, subprocess.Popen[bytes]]] = []

    def open(self, scene: Scene, folder: Path | None = None) -> Broadcast | None:
        """Start them; None without a target. With a file, one is also made in the folder of the run."""
        if not self._targets:
            return None
        os.environ.setdefault("RUST_LOG", _QUIET)  # rerun reads it when it is imported
        from slam.run.viewer.broadcast import Broadcast

        files = [target.path for target in self._targets if target.kind == "file"]
        if files and folder is not None:
            files.append((folder / "run.rrd").resolve())
        urls = list(dict.fromkeys(url for target in self._targets if (url := self._url(target))))
        return Broadcast(files, urls, scene, self.say)

    def open_file(self, recording: Path) -> None:
        """Show a recording that is whole."""
        for target in self._targets:
            if target.kind == "file":
                self._copied(recording, target.path)
            elif target.kind == "connect":
                self._sent(recording, target.url)
            elif target.kind == "spawn":
                self._spawned(recording)
            else:
                self._served(target.port, recording)

    def say(self, text: str) -> None:
        """Tell the user, in one line."""
        self._console.print(text)

    def serve_until_interrupted(self) -> None:
        """While a page is served, wait for Ctrl-C."""
        for address, server in self._servers:
            self.say(f"still served: {address}\nCtrl-C ends it")
            with suppress(KeyboardInterrupt):
                server.wait()

    def _url(self, target: Target) -> str | None:
        """Address of the viewer to send to, after it was started; None for a file, and where there cannot be one."""
        if target.kind == "file":
            return None
        if target.kind == "spawn":
            return self._spawned()
        return self._served(target.port) if target.kind == "serve" else target.url

    def _spawned(self, *files: Path) -> str | None:
        from slam.run.viewer.rerun_program import data_address, has_display, spawn_viewer

        url = data_address(GRPC_PORT)
        if not files and is_listening(url):
            return url
        if not has_display():
            self.say(NO_DISPLAY)
            return None
        spawn_viewer("auto" if files else str(GRPC_PORT), *files)
        return url

    def _served(self, port: int, *files: Path) -> str:
        from slam.run.viewer.rerun_program import data_address, page_address, serve_page

        self._servers.append((page_address(port), serve_page(port, *files)))
        self.say(f"viewer: {page_address(port)}")
        return data_address(port + 1)

    def _copied(self, recording: Path, path: Path) -> None:
        if path != recording.resolve():
            copyfile(recording, path)
        self.say(f"recording in {path}")

    def _sent(self, recording: Path, url: str) -> None:
        from slam.run.viewer.broadcast import send_file

        if not is_listening(url):
            raise InputError(f"--rerun connect: no viewer at {url}; start one there with: rerun")
        send_file(recording, url)
        self.say(f"sent to {url}")

    def close(self) -> None:
        """End the servers."""
        for _, server in self._servers:
            server.terminate()
            server.wait()
