"""Things named as ``module:name``, imported when they are used."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from slam.errors import InputError


def late(place: str) -> Any:
    """What stands at ``module:name``; InputError when Python finds no such module, or nothing of that name in it."""
    module, _, name = place.partition(":")
    try:
        return getattr(import_module(module), name)
    except ModuleNotFoundError as error:
        if error.name is None or not f"{module}.".startswith(f"{error.name}."):
            raise  # the module is there, and misses another one
        raise InputError(
            f"{place}: Python finds no module {error.name}; put its folder on PYTHONPATH, or install it"
        ) from error
    except AttributeError as error:
        raise InputError(f"{place}: {error}") from error
