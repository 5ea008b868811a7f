"""``--set key=value``: settings that override a file."""

from collections.abc import Iterable, Iterator
from typing import Any, Final

from slam.errors import ScenarioError, shown
from slam.scenario.random_value import is_random
from slam.scenario.yaml_file import YAML_ERRORS, KeyPath, explain_yaml_error, load_yaml

_CODE_KEYS: Final[tuple[KeyPath, ...]] = (("slam", "lines", "method"), ("slam", "matching", "method"))
"""Keys whose value may name the user's own code."""


def one_or_several(given: str | Iterable[str]) -> tuple[str, ...]:
    """Turn a single string into a list of one, not of its letters; ScenarioError for anything but strings."""
    several = (given,) if isinstance(given, str) else tuple(given) if isinstance(given, Iterable) else (None,)
    if not all(isinstance(one, str) for one in several):
        raise ScenarioError(f"expected a string, or a list of strings (got {shown(given)})")
    return several


def with_seed(settings: str | Iterable[str], seed: int | None) -> list[str]:
    """Return these settings, and the seed if one is given."""
    return [*one_or_several(settings), *([] if seed is None else [f"seed={seed}"])]


def parse_setting(text: str) -> tuple[KeyPath, Any]:
    """Parse ``slam.lines.psi=1`` into a path and a value, which is YAML; a number in the path is an index."""
    key, equals, value = text.partition("=")
    if not equals or not all(key.strip().split(".")):
        raise ScenarioError(f"--set {text}: expected key=value, for example --set duration=60")
    try:
        parsed = load_yaml(value)
    except YAML_ERRORS as error:
        _, fault = explain_yaml_error(error)
        raise ScenarioError(f"--set {text}: the value is not valid YAML: {fault}; quote it if it is text") from error
    return tuple(int(step) if step.isascii() and step.isdigit() else step for step in key.strip().split(".")), parsed


def apply_settings(data: dict[str, Any], settings: Iterable[tuple[KeyPath, Any]]) -> None:
    """Write each setting into the nested ``data``; mappings that its path needs are added."""
    for key_path, value in settings:
        at: Any = data
        for step in key_path[:-1]:
            at = _enter(at, step, key_path)
        _check_item(at, key_path[-1], key_path)
        at[key_path[-1]] = value


def named_code(settings: Iterable[tuple[KeyPath, Any]]) -> Iterator[str]:
    """Find the ``module:name`` places that settings name as parts of the method; naming them there allows them."""
    for key_path, value in settings:
        for key in _CODE_KEYS:
            if key_path == key[: len(key_path)]:
                yield from _code_in(value, key[len(key_path) :])


def _code_in(value: Any, rest: KeyPath) -> Iterator[str]:
    """Find the code at the rest of the path, including all choices of a random value."""
    if is_random(value):
        for choice in value.get("choice", ()):
            yield from _code_in(choice, rest)
    elif rest and isinstance(value, dict):
        yield from _code_in(value.get(rest[0]), rest[1:])
    elif not rest and isinstance(value, str) and ":" in value:
        yield value


def _enter(at: Any, step: str | int, key_path: KeyPath) -> Any:
    if isinstance(at, dict):
        if at.get(step) is None:
            at[step] = {}
        return at[step]
    _check_item(at, step, key_path)
    return at[step]


def _check_item(at: Any, step: str | int, key_path: KeyPath) -> None:
    """Refuse a path through a plain value, or to a missing item of a list."""
    name = ".".join(map(str, key_path))
    if isinstance(at, list):
        if not isinstance(step, int) or step >= len(at):
            raise ScenarioError(f"--set {name}: there are {len(at)} items here; {step} is not in 0 to {len(at) - 1}")
    elif not isinstance(at, dict):
        raise ScenarioError(f"--set {name}: {step} lies inside {at!r}, which has no parts")
