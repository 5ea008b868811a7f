"""Files that were sent along with the code to the machines of a cluster."""

from __future__ import annotations

from pathlib import Path
from typing import Final

SENT: Final = Path("sent")
"""Beside the packages: there each file lies under the path that it has on the driver's machine."""


def shipped_file(source: str) -> str:
    """Where a scenario or log is on this machine: among the files that were sent, or at its own path."""
    path = Path(source)
    if not path.is_absolute():
        return source
    sent = Path(__file__).parents[2] / SENT / path.relative_to("/")
    return str(sent) if sent.is_file() else source
