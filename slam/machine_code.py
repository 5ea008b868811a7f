"""Machine code of a hot loop, compiled once, together with the code of all its callees."""

# mypy: disable-error-code="no-untyped-call"
# numba's classes are typed only in part.

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache, cached_property
from typing import Any

from llvmlite.binding import Linkage  # type: ignore[import-untyped]
from numba.core.codegen import JITCodeLibrary, JITCPUCodegen
from numba.core.targetconfig import TargetConfig


@contextmanager
def making_code(target_context: Any) -> Iterator[None]:
    """Let numba compile with this module; the caller holds numba's lock.

    Meanwhile numba makes no entries for C, which nobody calls, and compares its flags quickly. Garbage collection is
    off: with numba's many objects it would take a twelfth of the time.
    """
    from numba.np import arrayobj  # 0.03 s, not spent if slam is only imported

    collects = gc.isenabled()
    gc.disable()
    try:
        with (
            _instead(target_context, _internal_codegen=_code_generator(), create_cfunc_wrapper=_nothing),
            _instead(arrayobj, raise_with_shape_context=_shape_error()),
            _instead(TargetConfig, __hash__=_flags_hash, __eq__=_same_flags),
        ):
            yield
    finally:
        if collects:
            gc.enable()


@contextmanager
def _instead(owner: Any, **attributes: Any) -> Iterator[None]:
    """Set these attributes of an object or class of numba's while the block runs."""
    usual = {name: getattr(owner, name) for name in attributes}
    for name, value in attributes.items():
        setattr(owner, name, value)
    try:
        yield
    finally:
        for name, value in usual.items():
            setattr(owner, name, value)


def _nothing(*_: Any) -> None: ...


def _flags_hash(flags: TargetConfig) -> int:
    return _hash_of_names(type(flags))


@cache
def _hash_of_names(flags: type[TargetConfig]) -> int:
    return hash(tuple(sorted(flags.options)))


def _same_flags(flags: TargetConfig, other: object) -> Any:
    """Compare the options that are set in either; the others have their default in both."""
    if type(flags) is not type(other):
        return NotImplemented
    one, two = flags._values, other._values
    return one == two or all(getattr(flags, name) == getattr(other, name) for name in one.keys() | two.keys())


def makes_code(target_context: Any) -> bool:
    """Return True while a hot loop is being compiled: numba then compiles one of its callees."""
    return isinstance(target_context.codegen(), _CodeGenerator)


class _Code(JITCodeLibrary):
    """Code of a function, optimised when Python first asks for it, with copies of all its callees.

    numba optimises each function alone, and again inside each of its direct and indirect callers. Here a function that
    only compiled code calls is not optimised alone: each caller has its own copy of it. A function that Python calls
    too is optimised both ways. The two results may sum in different orders, so callers never share code with it:
    otherwise results would depend on which was compiled first.
    """

    _unlinked_module: Any = None

    def add_llvm_module(self, ll_module: Any) -> None:
        self._final_module.link_in(ll_module)

    def add_linking_library(self, library: Any) -> None:
        self._linking_libraries.append(library)

    def get_pointer_to_function(self, name: str) -> Any:
        """Return the address of a function, 0 if it has none: parts have no entry for Python."""
        return super().get_pointer_to_function(name) if self._finalized or self._has(name) else 0

    def finalize(self) -> None:
        """Link and optimise; the parts stay unchanged for other callers."""
        self._unlinked_module, self._final_module = self._final_module, self._final_module.clone()
        own = {function.name for function in self._unlinked_module.functions if not function.is_declaration}
        for library in self._callees():
            self._reload_init.update(library._reload_init)
            part = library.part if isinstance(library, _Code) else library._get_module_for_linking()
            self._final_module.link_in(part, preserve=True)
        for function in self._final_module.functions:
            if not function.is_declaration and function.name not in own:
                function.linkage = "internal"
        self._optimize_final_module()
        self._final_module.verify()
        self._finalize_final_module()

    @cached_property
    def part(self) -> Any:
        """Code of this function alone, which its callers link.

        Symbols may occur in several parts, as two functions may contain the same helper of numba's.
        """
        module = (self._unlinked_module or self._final_module).clone()
        for function in module.functions:
            if not function.is_declaration and function.linkage == Linkage.external:
                function.linkage = "linkonce_odr"
        return module

    def _has(self, name: str) -> bool:
        return any(function.name == name for function in self._final_module.functions)

    def _callees(self) -> list[Any]:
        """Return all direct and indirect callees, each once."""
        found: list[Any] = [self]
        for library in found:
            found += [callee for callee in dict.fromkeys(library._linking_libraries) if callee not in found]
        return found[1:]


class _CodeGenerator(JITCPUCodegen):
    """Generates ``_Code`` objects in its own engine."""

    _library_class = _Code

    def set_env(self, env_name: str, env: Any) -> None:
        if self._engine.is_symbol_defined(env_name):  # parts have no such symbol
            super().set_env(env_name, env)


@cache
def _shape_error() -> Any:
    """Raises the error of an assignment to a slice; numba's own message names the shapes, and takes 3 s to compile."""
    from numba.extending import overload

    def shapes_differ(from_shape: Any, to_shape: Any) -> None: ...

    @overload(shapes_differ)
    def _(from_shape: Any, to_shape: Any) -> Any:
        def code(from_shape: Any, to_shape: Any) -> None:
            raise ValueError("cannot assign slice from input of different size")

        return code

    return shapes_differ


@cache
def _code_generator() -> _CodeGenerator:
    return _CodeGenerator("hopslam")
