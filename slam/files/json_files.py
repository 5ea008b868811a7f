"""Reading of JSON files within limits."""

import json
from pathlib import Path
from typing import Any, NoReturn

from slam.errors import InputError
from slam.limits import JSON_SIZE


def read_json(path: Path, remedy: str) -> Any:
    """Read the content of a file; InputError, which ends with advice, if it cannot be read or is not JSON."""
    try:
        return parse_json(read_bounded(path))
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be read: {error}; {remedy}") from error


def read_bounded(path: Path) -> bytes:
    """Read the bytes of a file; ValueError for more than the limit, OSError if they cannot be read."""
    if excess := JSON_SIZE.excess(path.stat().st_size):
        raise ValueError(excess)
    return path.read_bytes()


def parse_json(text: bytes) -> Any:
    """Parse JSON; ValueError for anything else, for NaN, and for too deep nesting."""
    try:
        return json.loads(text, parse_constant=_refuse)
    except RecursionError:
        raise ValueError("lists or objects are nested too deeply") from None


def _refuse(name: str) -> NoReturn:
    raise ValueError(f"{name} is not a JSON number")
