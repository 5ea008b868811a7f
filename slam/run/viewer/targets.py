"""``--rerun``: where a run is to be shown."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal
from urllib.parse import urlsplit

from slam.errors import InputError
from slam.scenario.settings import one_or_several

GRPC_PORT: Final = 9876
WEB_PORT: Final = 9090
FORMS: Final = "FILE.rrd, spawn, connect[=URL] or serve[=PORT]"


@dataclass(frozen=True, slots=True)
class Target:
    """One place to show a run at."""

    kind: Literal["file", "spawn", "connect", "serve"]
    path: Path = Path()
    """Path of a file."""
    url: str = f"rerun+http://127.0.0.1:{GRPC_PORT}/proxy"
    """Address of a viewer to connect to."""
    port: int = WEB_PORT
    """Port of the web page that is served; the data is served at the port after it."""


def parse_targets(given: str | Iterable[str]) -> list[Target]:
    """Parse all options, each target once; InputError for another form, or a file that cannot be written."""
    return list(dict.fromkeys(map(parse_target, one_or_several(given))))


def parse_target(text: str) -> Target:
    """Parse one option; InputError for what is none of the forms, or a file that cannot be written."""
    kind, _, value = text.partition("=")
    if text == "spawn":
        return Target("spawn")
    if kind == "connect":
        return Target("connect", url=_url(value, text)) if value else Target("connect")
    if kind == "serve":
        return Target("serve", port=_port(value, text)) if value else Target("serve")
    return Target("file", path=_file(Path(text)))


def _url(value: str, text: str) -> str:
    """An address as rerun writes it; of HOST or HOST:PORT too."""
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
