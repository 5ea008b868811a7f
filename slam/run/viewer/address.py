"""Who listens at an address."""

from __future__ import annotations

import socket
from contextlib import suppress
from urllib.parse import urlsplit


def listens(url: str) -> bool:
    """Whether anyone takes connections at the host and port of this address."""
    place = urlsplit(url)
    with suppress(OSError), socket.create_connection((place.hostname, place.port or 80), timeout=0.5):
        return True
    return False


def is_free(port: int) -> bool:
    """Whether this port of the loopback interface can be listened at."""
    with suppress(OSError), socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        probe.bind(("127.0.0.1", port))
        return True
    return False
