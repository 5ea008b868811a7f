"""Compiled code on disk, and what it was compiled from."""

# mypy: disable-error-code="no-untyped-call"
# numba's classes are typed only in part.

import re
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any, Final

import numpy as np
from numba.core.caching import FunctionCache
from numba.core.dispatcher import Dispatcher

_COMPILER: Final = [Path(__file__).with_name(name) for name in ("compiled.py", "kept_code.py", "machine_code.py")]
_STAMPS: Final = {file.name: file.stat().st_mtime_ns for file in _COMPILER}
"""Time stamps of the files that define how code is compiled."""


class KeptCode(FunctionCache):
    """Compiled code on disk, valid while everything that it was compiled from is unchanged.

    numba's own cache checks only the function's own file. What else a function calls is known once its module has been
    imported completely; it is therefore looked up at the first call.
    """

    def __init__(self, function: Any) -> None:
        super().__init__(function)
        self.file_stamp = self._cache_file._source_stamp

    def load_overload(self, signature: Any, target_context: Any) -> Any:
        """Return the code for arguments of these types; None if there is none that is valid and can be read."""
        self._look_up_sources()
        return self._read(lambda: super(KeptCode, self).load_overload(signature, target_context))

    def is_empty(self) -> bool:
        """Return True if there is a place for this function's code, and no valid code in it."""
        self._look_up_sources()
        return self._enabled and not self._read(self._cache_file._load_index)

    def _read(self, read: Callable[[], Any]) -> Any:
        """Read from disk; if that fails, drop the code and return None.

        It fails after a file was cut by a full disk, and where a type of the code has gone or has another name.
        """
        try:
            return read()
        except Exception:  # noqa: BLE001  # a damaged pickle raises nearly any
            with suppress(OSError):
                self._cache_file.flush()
            return None

    @contextmanager
    def compiled_once(self) -> Iterator[None]:
        """Let other processes that need the same function wait while the block runs, and then find it kept.

        Without such locks, on Windows and some network drives, two processes may compile the same function.
        """
        with ExitStack() as locked:
            if sys.platform != "win32":
                import fcntl

                with suppress(OSError):
                    file = locked.enter_context(Path(f"{self._cache_file._index_path}.lock").open("a"))
                    fcntl.flock(file, fcntl.LOCK_EX)
            yield

    def _look_up_sources(self) -> None:
        sources: dict[str, Any] = dict(_STAMPS)
        _add_sources(self._py_func, self, sources)
        self._cache_file._source_stamp = sources
        if None in sources.values():  # a callee without a place on disk: its changes cannot be detected
            self.disable()


def _add_sources(function: Any, cache: Any, sources: dict[str, Any]) -> None:
    """Add the sources of a function: the stamps of its file and its callees' files, and the constants they use."""
    sources[_full_name(function)] = getattr(cache, "file_stamp", None)
    for name, value in _named_values(function):
        callee = value.py_func if isinstance(value, Dispatcher) else None
        if callee is None:
            sources |= _constant(name, value)
        elif _full_name(callee) not in sources:
            _add_sources(callee, value._cache, sources)


def _full_name(function: Any) -> str:
    return f"{function.__module__}.{function.__qualname__}"


def _named_values(function: Any) -> Iterator[tuple[str, Any]]:
    """Yield full names and values of the globals in a function's code and annotations, and of modules' attributes."""
    names = {name for annotation in function.__annotations__.values() for name in re.findall(r"\w+", str(annotation))}
    names |= _names(function.__code__)
    modules = [value for name in names if isinstance(value := function.__globals__.get(name), ModuleType)]
    for scope in (function.__globals__, *map(vars, modules)):
        yield from ((f"{scope['__name__']}.{name}", scope[name]) for name in names & scope.keys())


def _names(code: CodeType) -> set[str]:
    """Return names of globals and attributes in a function and in those defined inside it."""
    return set(code.co_names).union(*(_names(inner) for inner in code.co_consts if isinstance(inner, CodeType)))


def _constant(name: str, value: Any) -> dict[str, str]:
    """Return name and value as text, if compiled code holds a copy of such values; else nothing."""
    if isinstance(value, np.ndarray):
        return {name: f"{value.dtype} {value.tolist()}"}
    if isinstance(value, int | float | complex | str | tuple | np.generic):
        return {name: repr(value)}
    if isinstance(value, type) and hasattr(value, "_fields"):
        return {name: repr(value._fields)}  # a named tuple: the order of its fields
    return {}
