"""The cache of compiled code is used only while its sources are unchanged."""

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from itertools import product
from pathlib import Path

import pytest

FILES = {
    "__init__.py": "",
    "sizes.py": "FACTOR = 2.0\nOFFSETS = (1.0, 2.0)\n",
    "steps.py": "from slam.compiled import compiled\n\n@compiled\ndef add_one(x):\n    return x + 1.0\n",
    "halves.py": (
        "from slam.compiled import compiled\nfrom loops import steps\n\n"
        "@compiled\ndef outer(x):\n    return inner(x)\n\n"
        "@compiled\ndef inner(x):\n    return steps.add_one(x) / 2.0\n"
    ),
    "pairs.py": "from typing import NamedTuple\n\nclass Pair(NamedTuple):\n    left: float\n    right: float\n",
    "unrelated.py": "from slam.compiled import compiled\n\n@compiled\ndef unused(x):\n    return x\n",
    "top.py": (
        "from __future__ import annotations\n\n"
        "from slam.compiled import compiled\n"
        "from loops.halves import outer\nfrom loops.pairs import Pair\nfrom loops.sizes import FACTOR, OFFSETS\n"
        "from loops.unrelated import unused\n\n"
        "@compiled\ndef top(x, pair: Pair):\n    return outer(x) * FACTOR + OFFSETS[1] + 100.0 * pair.left\n"
    ),
}
SERVER = """
import os, sys
from numba.core import config
from slam.compiled import wrapped

wrapped(4.0)  # loads numba, once for all the processes below
for line in sys.stdin:
    if not os.fork():
        folder, program = line.split()
        if config.CACHE_DIR:
            config.CACHE_DIR = os.path.join(folder, "kept")
        sys.path.insert(0, folder)
        with open(program) as file:
            exec(file.read())
        sys.stdout.flush()
        os._exit(0)
    if os.wait()[1]:
        sys.exit("it failed")
    print("done", flush=True)
"""
"""Runs programs, each in a process of its own that has already loaded numba."""
PROGRAM = """
from loops.top import Pair, top
print(top(3.0, Pair(left=1.0, right=5.0)), sum(top.stats.cache_hits.values()), sum(top.stats.cache_misses.values()))
"""
CHAIN = """
import numpy as np
from slam.compiled import compiled

@compiled
def inner(x, y):
    total = 0.0
LOOPS
    return total

@compiled
def outer(x, y):
    steps = np.empty(len(x))
    for k in range(len(x)):
        steps[k] = inner(x[k:], y[k:]) / (1.0 + inner(x[:k], y[:k]))
    return inner(steps, y) * inner(steps, x)
"""
LOOP = """
    for i in range(len(x)):
        total += x[i] * y[i] / (1.0 + {0}.1 * x[i]) + {0}.3 * y[i]
    total += np.sin(total)
"""
CHAIN_PROGRAM = """
import numpy as np
from loops.chain import inner, outer
x, y = np.random.default_rng(0).random((2, 997))
CALL
print(outer(x, y).hex(), int(sum(outer.stats.cache_hits.values())))
"""
Run = Callable[[], tuple[float, bool]]
FIRST = 106.0  # (3 + 1) / 2 * 2 + 2 + 100


@pytest.fixture
def package(tmp_path: Path) -> Path:
    folder = tmp_path / "loops"
    folder.mkdir()
    for name, text in FILES.items():
        (folder / name).write_text(text)
    return folder


Server = Callable[[Path, str], list[str]]


@contextmanager
def served(cache: str, **environment: str) -> Iterator[Server]:
    """A function that returns the words that a program prints in a new process, with this package to import.

    With a ``cache`` folder, compiled code is kept beside the package; with an empty text numba chooses the place.
    """
    environment |= {"PYTHONPATH": str(Path(__file__).parent.parent), "NUMBA_CACHE_DIR": cache}
    command = [sys.executable, "-B", "-c", SERVER]
    with subprocess.Popen(
        command, env=os.environ | environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        questions, answers = process.stdin, process.stdout
        assert questions is not None
        assert answers is not None

        def run(package: Path, program: str) -> list[str]:
            file = package.parent / "program.py"
            file.write_text(program)
            print(package.parent, file, file=questions, flush=True)
            lines = list(iter(answers.readline, "done\n"))
            return " ".join(lines).split()

        yield run


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """See ``served``."""
    with served(str(tmp_path_factory.mktemp("kept"))) as run:
        yield run


def output(package: Path, words: str) -> list[str]:
    """The words that a program prints in a process that it starts."""
    path = os.pathsep.join([str(package.parent), str(Path(__file__).parent.parent)])
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(package.parent / "kept"), "PYTHONPATH": path}
    done = subprocess.run(
        [sys.executable, "-B", "-c", words], env=environment, capture_output=True, text=True, timeout=120, check=True
    )
    return done.stdout.split()


def answer(words: list[str]) -> tuple[float, bool]:
    """The result of top(), and True where its code was found on disk."""
    result, hits, misses = words
    assert int(hits) + int(misses) == 1
    return float(result), hits == "1"


@pytest.fixture
def run(package: Path, server: Server) -> Run:
    """A function that gives the ``answer`` of a new process."""
    return lambda: answer(server(package, PROGRAM))


def edit(file: Path, old: str, new: str) -> None:
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new))


def test_cached_code_is_used_while_its_sources_are_unchanged(package: Path, run: Run) -> None:
    assert run() == (FIRST, False)
    assert run() == (FIRST, True)
    edit(package / "unrelated.py", "return x", "return 2.0 * x")
    edit(package / "sizes.py", "FACTOR = 2.0", "UNUSED = 7.0\nFACTOR = 2.0")
    assert run() == (FIRST, True)


def test_an_edited_source_is_compiled_again(package: Path, run: Run) -> None:
    result = FIRST
    assert run() == (result, False)
    for file, old, new, more in [
        ("top.py", "100.0", "200.0", 100.0),
        ("halves.py", "/ 2.0", "/ 1.0", 4.0),  # a callee of a callee of another file
        ("steps.py", "x + 1.0", "x + 3.0", 4.0),  # a callee by its module's name
        ("sizes.py", "FACTOR = 2.0", "FACTOR = 3.0", 6.0),
        ("sizes.py", "(1.0, 2.0)", "(1.0, 4.0)", 2.0),
        ("pairs.py", "    left: float\n    right: float\n", "    right: float\n    left: float\n", 0.0),
    ]:
        edit(package / file, old, new)
        result += more
        assert run() == (result, False), f"{file}: {old} -> {new}"


def test_damaged_code_is_compiled_again(package: Path, run: Run) -> None:
    assert run() == (FIRST, False)
    for kind, size in product(("nbi", "nbc"), (0, -40)):
        (file,) = package.parent.glob(f"kept/**/top.top-*.{kind}")
        file.write_bytes(file.read_bytes()[:size])
        assert run() == (FIRST, False), f"{kind}, {size} bytes"
        assert run() == (FIRST, True)


def test_code_with_a_renamed_type_is_compiled_again(package: Path, run: Run) -> None:
    assert run() == (FIRST, False)
    edit(package / "pairs.py", "Pair(", "Couple(")
    edit(package / "top.py", "import Pair", "import Couple as Pair")
    assert run() == (FIRST, False)
    assert run() == (FIRST, True)


def test_code_compiles_without_a_cache_folder(package: Path) -> None:
    nowhere = package / "__pycache__"
    nowhere.write_text("a file, so that no folder can be made here")
    with served("", HOME=str(nowhere), XDG_CACHE_HOME=str(nowhere)) as server:
        assert [answer(server(package, PROGRAM)) for _ in range(2)] == [(FIRST, False)] * 2


def test_fresh_and_cached_code_give_the_same_bits(package: Path, server: Server) -> None:
    loops = "".join(LOOP.format(k) for k in range(4))  # too long to be inlined
    (package / "chain.py").write_text(CHAIN.replace("LOOPS", loops))
    alone, inner_first = CHAIN_PROGRAM.replace("CALL", ""), CHAIN_PROGRAM.replace("CALL", "inner(x, y)")
    (compiled, hits), (kept, kept_hits), (after_inner, _) = (server(package, p) for p in (alone, alone, inner_first))
    assert (hits, kept_hits) == ("0", "1")
    assert compiled == kept
    assert after_inner == kept


def test_copies_of_called_functions_are_hidden(package: Path, server: Server) -> None:
    (package / "chain.py").write_text(CHAIN.replace("LOOPS", LOOP.format(1)))
    words = CHAIN_PROGRAM.replace("CALL", "inner(x, y)") + (
        "library = next(iter(outer.overloads.values())).library\n"
        "seen = [f.name for f in library.get_defined_functions() if f.linkage.name != 'internal']\n"
        "print(sum('outer' in name for name in seen), sum('inner' in name or 'empty' in name for name in seen))\n"
    )
    *_, own, copies = server(package, words)
    assert int(own) >= 1
    assert copies == "0"


def test_a_function_is_cold_until_its_code_is_cached(package: Path, server: Server) -> None:
    words = "from slam.compiled import is_cold\nfrom loops.steps import add_one\nprint(is_cold(add_one), add_one(1.0))"
    assert server(package, words) == ["True", "2.0"]
    assert server(package, words) == ["False", "2.0"]
    edit(package / "steps.py", "x + 1.0", "x + 3.0")
    assert server(package, words) == ["True", "4.0"]


@pytest.mark.skipif(sys.platform == "win32", reason="no locks on Windows")
def test_two_processes_compile_a_function_once(package: Path) -> None:
    words = "from loops.steps import add_one\nprint(add_one(1.0), sum(add_one.stats.cache_misses.values()))"
    with ThreadPoolExecutor() as pool:
        answers = pool.map(lambda _: output(package, words), range(2))
    assert sorted(answers) == [["2.0", "0"], ["2.0", "1"]]


def test_a_literal_is_compiled_as_any_number(package: Path, server: Server) -> None:
    (package / "counts.py").write_text(
        "from slam.compiled import compiled\n\n"
        "@compiled\ndef more(x, by):\n    return x + by\n\n"
        "@compiled\ndef total(x):\n    y = more(x, by=1)\n    return more(more(y, 2), x) + more(0, y)\n"
    )
    words = "from loops.counts import more, total\nprint(total(1), len(more._parts))"
    assert server(package, words) == ["7", "1"]


def test_without_the_compiler_hot_loops_are_python() -> None:
    code = "from slam.compiled import wrapped; print(type(wrapped).__name__, round(wrapped(4.0), 6))"
    env = os.environ | {"NUMBA_DISABLE_JIT": "1"}
    printed = subprocess.run([sys.executable, "-c", code], env=env, check=True, capture_output=True, text=True).stdout
    assert printed.split() == ["function", "-2.283185"]
