"""Imports code named as ``module:name``, a user's own only if allowed, and optional packages."""

import sys
from collections.abc import Mapping, Sequence
from importlib import import_module
from inspect import Parameter, signature
from traceback import extract_tb
from typing import Any, Final

from slam.errors import HopslamError, InputError

PLACE: Final = r"^[A-Za-z_][\w.]*:[A-Za-z_]\w*$"
"""Pattern of the names of such code: ``module:name``."""
_NAMED: Final = (Parameter.POSITIONAL_OR_KEYWORD, Parameter.KEYWORD_ONLY)


def import_by_name(place: str) -> Any:
    """Import the object at ``module:name``; InputError if there is no such module, or no such name in it."""
    module, _, name = place.partition(":")
    try:
        return getattr(import_module(module), name)
    except ModuleNotFoundError as error:
        if error.name is None or not f"{module}.".startswith(f"{error.name}."):
            raise  # the module exists, and another one is missing
        raise InputError(
            f"{place}: Python finds no module {error.name}; put its folder on PYTHONPATH, or install it"
        ) from error
    except AttributeError as error:
        raise InputError(f"{place}: {error}") from error


def import_optional(module: str, extra: str) -> Any:
    """Import an optional module; if it is missing, InputError gives the command that installs the ``extra``."""
    try:
        return import_module(module)
    except ImportError as error:
        package = module.partition(".")[0]
        raise InputError(f"{package} is not installed; run: pip install 'hopslam[{extra}]'") from error


def is_allowed(place: str, allowed: Sequence[str]) -> bool:
    """Return True if ``allowed`` has this place, its module, or a package that contains the module."""
    module = place.partition(":")[0]
    return place in allowed or any(f"{module}.".startswith(f"{name}.") for name in allowed if ":" not in name)


def refusal(place: str) -> str:
    """Describe why a file may not name this place, and how the user allows it."""
    module = place.partition(":")[0]
    return (
        f"a file may not run code, and {place} is code; if you trust the module {module}, add --allow-module {module} "
        f"(in Python: allow_modules=['{module}'])"
    )


def find_code(place: str, allowed: Sequence[str]) -> Any:
    """Import the function or class at this place.

    InputError if it is not allowed, does not exist, or its module fails. Allowing a module allows what its own package
    defines, and not what it has imported from others.
    """
    if not is_allowed(place, allowed):
        raise InputError(refusal(place))
    try:
        code = import_by_name(place)
    except InputError:
        raise
    except Exception as error:
        raise InputError(f"{place}: {_one_line(error, place)}") from error
    if place not in allowed and not _defined_there(code, place):
        raise InputError(f"{place} comes from another module; if you trust it, add --allow-module {place}")
    if not callable(code):
        raise InputError(f"{place} is of type {type(code).__name__}; a function or a class belongs here")
    return code


def call(
    place: str,
    code: Any,
    *arguments: Any,
    options: Mapping[str, Any] = {},
    raises: type[HopslamError] = InputError,
    **more: Any,
) -> Any:
    """Call the code, and return its result. ``options`` are the user's keyword arguments, ``more`` are this project's.

    Raises ``raises``, of one line, if it does not take these arguments or raises anything but an error of this project.
    """
    try:
        return code(*arguments, **more, **options)
    except HopslamError:
        raise
    except Exception as error:
        reason = _refused(code, arguments, more, options) if isinstance(error, TypeError) else None
        raise raises(f"{place} {reason}" if reason else f"{place}: {_one_line(error, place)}") from error


def _defined_there(code: Any, place: str) -> bool:
    """Return True if the definition is in the same package as the module at this place."""
    package = str(import_module(place.partition(":")[0]).__name__).partition(".")[0]
    return str(getattr(code, "__module__", "")).partition(".")[0] == package


def _refused(code: Any, arguments: Sequence[Any], more: Mapping[str, Any], options: Mapping[str, Any]) -> str | None:
    """List the arguments that the code does not take; None if it takes all, or if its signature is unknown."""
    try:
        taken = signature(code)
    except (TypeError, ValueError):
        return None
    named = [name for name, parameter in taken.parameters.items() if parameter.kind in _NAMED]
    own = [name for name in named[len(arguments) :] if name not in more]
    try:
        taken.bind(*arguments, **more, **options)
    except TypeError as error:
        unknown = [name for name in options if name not in own]
        if unknown:
            return f"takes no option {unknown[0]!r}; it takes {', '.join(own) or 'none'}"
        return f"does not take what it is called with: {error}; see docs/extend.md"
    return None


def _one_line(error: Exception, place: str) -> str:
    """Describe the error in one line, with the line of the module in which it occurred."""
    if isinstance(error, SyntaxError):
        return f"SyntaxError: {error.msg} ({error.filename}:{error.lineno})"
    file = getattr(sys.modules.get(place.partition(":")[0]), "__file__", None)
    frames = extract_tb(error.__traceback__)
    frame = next((frame for frame in reversed(frames) if frame.filename == file), frames[-1])
    line = next(iter(str(error).splitlines()), "")
    return f"{type(error).__name__}: {line} ({frame.filename}:{frame.lineno})"
