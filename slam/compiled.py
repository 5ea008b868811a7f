"""Compiles the hot loops with numba, keeps the result on disk, and lets sums be vectorised."""

# mypy: disable-error-code="no-untyped-call"
# numba's classes have types in part.

import re
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any, TypeVar, cast

import numpy as np
from numba import njit
from numba.core.caching import FunctionCache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.dispatcher import Dispatcher

_FASTMATH = {"reassoc", "contract", "nsz", "arcp"}
_STAMP = Path(__file__).stat().st_mtime_ns
"""Time stamp of this file, which decides how code is compiled."""
F = TypeVar("F", bound=Callable[..., Any])


def compiled(function: F) -> F:
    """Compile an array function at its first call; the result is kept on disk for the next process.

    Additions may be reordered and a division by zero gives infinity, which lets the compiler use vector registers; a
    NaN stays a NaN. On one machine the same input gives the same bits, whether the code was compiled just now or kept,
    and whatever ran before. While one runs, other threads run too.

    The kept result is compiled anew when one of these changed: the function's file, the file of a compiled function
    that it reaches, this file, or the value of a constant that one of them uses. They may come from any module.
    """
    return _compiled(function, counts_references=True)


def compiled_on_views(function: F) -> F:
    """Compile as ``compiled`` does a function that makes no array of its own, and takes none from one that does.

    It counts no references. Counting costs a few nanoseconds for each array that is passed on, and threads that count
    those of the same array wait for each other.
    """
    return _compiled(function, counts_references=False)


def _compiled(function: F, *, counts_references: bool) -> F:
    """Make the dispatcher; ``_nrt`` is numba's own name for its run time, which counts references to arrays."""
    options: dict[str, Any] = {"nogil": True, "error_model": "numpy", "fastmath": _FASTMATH, "_nrt": counts_references}
    dispatcher: Any = cast(Any, njit)(pipeline_class=_Compiler, **options)(function)
    with suppress(RuntimeError):  # neither beside the source nor at home is there a place to keep it
        dispatcher._cache = _Cache(function)
    return cast(F, dispatcher)


class _Compiler(Compiler):
    """numba's compiler, but that code calls its own copies of its callees."""

    def define_pipelines(self) -> Any:
        state = self.state
        state.library = _CodeWithItsCallees(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        return super().define_pipelines()


class _CodeWithItsCallees(JITCodeLibrary):
    """Machine code of a function that calls its own copies of its callees, never those of the process.

    A copy was optimised once more, with its caller, and may add in another order than the callee alone. numba lets the
    linker take the first of them in the process: the callee where it was just compiled or called before, else a copy.
    """

    def _finalize_final_module(self) -> None:
        self._finalized = True  # what callers of this function copy is taken before its copies are hidden
        self._get_module_for_linking()
        for function in self._final_module.functions:
            if function.linkage.name == "linkonce_odr":
                function.linkage = "internal"
        super()._finalize_final_module()


class _Cache(FunctionCache):
    """Compiled code on disk, valid while everything that it was compiled from is the same.

    numba's own cache asks only for the function's own file. What else a function reaches is known once its module has
    been imported whole; it is therefore looked up at the first call.
    """

    def __init__(self, function: Any) -> None:
        super().__init__(function)
        self.file_stamp = self._cache_file._source_stamp

    def load_overload(self, signature: Any, target_context: Any) -> Any:
        sources: dict[str, Any] = {__name__: _STAMP}
        _add_sources(self._py_func, self, sources)
        self._cache_file._source_stamp = sources
        if None in sources.values():  # a callee without a place on disk: nothing tells when it changes
            self.disable()
        return super().load_overload(signature, target_context)


def _add_sources(function: Any, cache: Any, sources: dict[str, Any]) -> None:
    """Add what a function is compiled from: the stamps of its file and of its callees', the constants they use."""
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
    """Full names and values of the globals in a function's code and annotations, modules' attributes among them."""
    names = {name for annotation in function.__annotations__.values() for name in re.findall(r"\w+", str(annotation))}
    names |= _names(function.__code__)
    modules = [value for name in names if isinstance(value := function.__globals__.get(name), ModuleType)]
    for scope in (function.__globals__, *map(vars, modules)):
        yield from ((f"{scope['__name__']}.{name}", scope[name]) for name in names & scope.keys())


def _names(code: CodeType) -> set[str]:
    """Names of globals and attributes in a function and in those defined inside it."""
    return set(code.co_names).union(*(_names(inner) for inner in code.co_consts if isinstance(inner, CodeType)))


def _constant(name: str, value: Any) -> dict[str, str]:
    """A value by its name, as text, if compiled code holds a copy of such values; else nothing."""
    if isinstance(value, np.ndarray):
        return {name: f"{value.dtype} {value.tolist()}"}
    if isinstance(value, int | float | complex | str | tuple | np.generic):
        return {name: repr(value)}
    if isinstance(value, type) and hasattr(value, "_fields"):
        return {name: repr(value._fields)}  # a named tuple: the order of its fields
    return {}


@compiled_on_views
def wrapped(angle: float) -> float:
    """``wrap_angle`` for compiled code: the same angle in [-pi, pi]; radians."""
    return float(angle - 2.0 * np.pi * np.rint(angle / (2.0 * np.pi)))
