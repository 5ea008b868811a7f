"""The rule that keeps compiled functions from going stale."""

import importlib
import pkgutil

import slam
from slam.compiled import compiled

DISPATCHER = type(compiled(lambda x: x))


def test_compiled_functions_call_only_compiled_functions_of_their_own_file() -> None:
    """numba renews what it kept when the file of a function changes, but not when that of a callee does."""
    found = 0
    for info in pkgutil.walk_packages(slam.__path__, "slam."):
        module = importlib.import_module(info.name)
        for name, function in vars(module).items():
            if isinstance(function, DISPATCHER) and function.py_func.__module__ == info.name:
                found += 1
                for callee in function.py_func.__code__.co_names:
                    called = getattr(module, callee, None)
                    if isinstance(called, DISPATCHER):
                        assert called.py_func.__module__ == info.name, f"{info.name}.{name} calls {callee}"
    assert found >= 5
