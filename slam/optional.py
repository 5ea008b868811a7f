"""Packages that only some commands need."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from slam.errors import InputError


def optional(module: str, extra: str) -> Any:
    """The module of that name; InputError names the command that installs it, with its ``extra``, where it is not."""
    try:
        return import_module(module)
    except ImportError as error:
        package = module.partition(".")[0]
        raise InputError(f"{package} is not installed; run: pip install 'hopslam[{extra}]'") from error
