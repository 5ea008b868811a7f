"""Compiles the hot loops with numba, keeps the result on disk, and lets sums be vectorised."""

# mypy: disable-error-code="no-untyped-call"
# numba's classes are typed only in part.

from collections.abc import Callable
from contextlib import nullcontext, suppress
from functools import cached_property
from typing import Any, Final, TypeVar, cast

import numpy as np
from numba.core import config
from numba.core.compiler import Compiler
from numba.core.compiler_lock import global_compiler_lock
from numba.core.dispatcher import _FunctionCompiler  # type: ignore[attr-defined]  # it has no types
from numba.core.event import trigger_event
from numba.core.registry import CPUDispatcher
from numba.core.sigutils import normalize_signature
from numba.core.types import unliteral

from slam.kept_code import KeptCode
from slam.machine_code import makes_code, making_code

_OPTIONS: Final[dict[str, Any]] = {
    "nopython": True,
    "nogil": True,
    "error_model": "numpy",
    "no_cfunc_wrapper": True,
}
_REORDERED: Final[dict[str, Any]] = {"fastmath": {"reassoc", "contract", "nsz", "arcp"}}
F = TypeVar("F", bound=Callable[..., Any])


def compiled(function: F) -> F:
    """Compile an array function at its first call; the result is kept on disk for the next process.

    Additions may be reordered and a division by zero gives infinity, which lets the compiler use vector registers; a
    NaN stays a NaN. On one machine the same input gives the same bits, whether the code was compiled just now or kept,
    and whatever ran before. Other threads run at the same time.

    The function is compiled again if one of these has changed: this file; the file of the function, or of a compiled
    function that it calls directly or indirectly; the value of a constant that any of these functions uses.
    """
    return _compiled(function, _REORDERED | {"_nrt": True})


def compiled_on_views(function: F) -> F:
    """Compile a function that makes no array, as ``compiled`` does, without reference counts.

    It must not take an array from a function that makes one. Counting costs a few nanoseconds for each array that is
    passed on, and threads that count references to the same array wait for each other.
    """
    return _compiled(function, _REORDERED | {"_nrt": False})


def compiled_in_order(function: F) -> F:
    """Compile as ``compiled_on_views`` does, but keep every operation and its order: the bits are those of Python."""
    return _compiled(function, {"_nrt": False})


def is_cold(function: Callable[..., Any]) -> bool:
    """Return True if the first call of this compiled function will compile it and keep the result."""
    kept = getattr(function, "_cache", None)
    return isinstance(kept, KeptCode) and kept.is_empty()


def _compiled(function: F, options: dict[str, Any]) -> F:
    """Make the dispatcher; ``_nrt`` is numba's name for its run time, which counts references to arrays.

    With ``NUMBA_DISABLE_JIT=1`` the function stays Python, for debuggers and for coverage.
    """
    if config.DISABLE_JIT:  # type: ignore[attr-defined]  # numba sets it as it is imported
        return function
    return cast(F, _HotLoop(function, _OPTIONS | options))


class _HotLoop(CPUDispatcher):
    """A function with its own code for calls from Python, and code inlined into compiled functions that call it.

    Only code for calls from Python is optimised and kept on disk. It contains the functions that it calls, so that a
    program which finds it on disk need not compile these.
    """

    def __init__(self, function: Any, options: dict[str, Any]) -> None:
        super().__init__(function, targetoptions=options)
        self._parts: dict[Any, Any] = {}  # results by types of arguments, like numba's ``overloads``
        with suppress(RuntimeError):  # there is no place to keep it, neither beside the source nor in the home folder
            self._cache = KeptCode(function)

    @cached_property
    def _part_compiler(self) -> Any:
        options = self.targetoptions | {"no_cpython_wrapper": True}
        return _FunctionCompiler(self.py_func, self.targetdescr, options, {}, Compiler)

    def compile(self, sig: Any) -> Any:
        """Return the entry for arguments of these types, compiled if it is not yet; numba calls this."""
        with global_compiler_lock:
            if makes_code(self.targetctx):
                return self._part(sig).entry_point
            kept = self._cache
            with making_code(self.targetctx), kept.compiled_once() if isinstance(kept, KeptCode) else nullcontext():
                return super().compile(sig)

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Resolve a call from compiled code; a literal counts as any number of its type."""
        return super().get_call_template([unliteral(arg) for arg in args], {name: unliteral(kws[name]) for name in kws})

    def get_overload(self, sig: Any) -> Any:
        """Return the entry that was compiled for this signature; numba calls this where compiled code calls it."""
        return self._part(sig).entry_point if makes_code(self.targetctx) else super().get_overload(sig)

    @property
    def nopython_signatures(self) -> Any:
        """Signatures that compiled code may call; numba asks for them after ``compile``."""
        results: dict[Any, Any] = self._parts if makes_code(self.targetctx) else self.overloads
        return [result.signature for result in results.values()]

    def _part(self, sig: Any) -> Any:
        """The result of compiling a part; the counter lets numba recognise a function that calls itself."""
        args, return_type = normalize_signature(sig)
        if args not in self._parts:
            details = {"dispatcher": self, "args": args, "return_type": return_type}
            with self._compiling_counter, trigger_event("numba:compile", data=details):
                self._parts[args] = self._part_compiler.compile(args, return_type)
        return self._parts[args]


@compiled_on_views
def wrapped(angle: float) -> float:
    """``wrap_angle`` for compiled code: the same angle in [-pi, pi]; radians."""
    return float(angle - 2.0 * np.pi * np.rint(angle / (2.0 * np.pi)))
