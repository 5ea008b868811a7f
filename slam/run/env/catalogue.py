"""The registered environments by id."""

from __future__ import annotations

from difflib import get_close_matches
from importlib import import_module

import gymnasium

from slam.errors import InputError

_NAMESPACE = "hopslam"


def env_ids() -> dict[str, str | None]:
    """Every id with the scenario it stands for; None where that is an argument."""
    import_module("sim")  # registers them
    specs = [spec for spec in gymnasium.registry.values() if spec.namespace == _NAMESPACE]
    return {spec.id: spec.kwargs.get("scenario") for spec in specs}


def find_env_id(name: str) -> str:
    """The whole id of this name, given with or without ``hopslam/``; InputError names what was perhaps meant."""
    known = env_ids()
    whole = name if name in known else f"{_NAMESPACE}/{name}"
    if whole in known:
        return whole
    close = get_close_matches(whole, known, n=1)
    hint = f"did you mean {close[0]}?" if close else f"choose one of {', '.join(known)}"
    raise InputError(f"no environment {name!r}; {hint}")
