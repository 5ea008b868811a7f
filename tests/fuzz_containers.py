"""Damaged files into every reader: ``python -m tests.fuzz_containers [INPUTS] [SEED] [READER]`` from the top of the tree.

Whatever comes in, only an error of slam.errors may come out. Each reader gets valid files of its kind in which bytes
were changed, dropped, doubled or cut off; an input is made again from its reader's name, the seed and its number.
"""

import random
import shutil
import sys
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from slam.errors import HopslamError
from tests.fuzz_seeds import READERS, Reader

_JUNK = (b"\xff", b"\0", b"-1", b"9" * 30, b"nan", b"[" * 2000, b"\xff\xff\xff\xff\xff\xff\xff\x7f", b"\n", b'"', b"{}")


@dataclass
class Failures:
    """Inputs of one reader that were not tamed."""

    inputs: int = 0
    refused: int = 0
    untamed: list[str] = None  # type: ignore[assignment]

    def __post_init__(self) -> None:
        self.untamed = []


def damaged(whole: bytes, rng: random.Random) -> bytes:
    """The bytes after one to four damages, or cut off."""
    data = bytearray(whole)
    if rng.random() < 0.2:
        return bytes(data[: rng.randrange(len(data) + 1)])
    for _ in range(rng.randrange(1, 5)):
        at = rng.randrange(len(data) + 1)
        kind = rng.randrange(5)
        if kind == 0 and data:
            data[at % len(data)] ^= 1 << rng.randrange(8)
        elif kind == 1:
            data[at : at + 1] = rng.randbytes(1)
        elif kind == 2:
            del data[at : at + rng.choice([1, 1, 4, 100, 4096])]
        elif kind == 3:
            data[at:at] = data[at : at + rng.choice([1, 8, 64])]
        else:
            junk = rng.choice(_JUNK)
            data[at : at + rng.choice([0, len(junk)])] = junk
    return bytes(data)


def try_reader(name: str, reader: Reader, seeds: Path, inputs: int, seed: int) -> Failures:
    """Feed the reader so many inputs."""
    found, files = Failures(), reader.files(seeds)
    with TemporaryDirectory(prefix="hopslam-fuzz-") as folder:
        here = Path(folder) / seeds.name
        shutil.copytree(seeds, here, symlinks=True)
        for number in range(inputs):
            rng = random.Random(f"{name} {seed} {number}")
            file = rng.choice(files)
            feed(found, reader, here, file, damaged((seeds / file).read_bytes(), rng), f"{name} {seed} {number}")
            reader.restore(seeds, here, file)
    return found


def try_cuts(name: str, reader: Reader, seeds: Path) -> Failures:
    """Feed the reader each of its small files cut at every byte, and larger ones at a thousand places."""
    found = Failures()
    with TemporaryDirectory(prefix="hopslam-fuzz-") as folder:
        here = Path(folder) / seeds.name
        shutil.copytree(seeds, here, symlinks=True)
        for file in reader.files(seeds):
            whole = (seeds / file).read_bytes()
            for end in range(0, len(whole), max(len(whole) // 1000, 1)):
                feed(found, reader, here, file, whole[:end], f"{name} {file} cut at {end}")
            reader.restore(seeds, here, file)
    return found


def feed(found: Failures, reader: Reader, here: Path, file: str, data: bytes, label: str) -> None:
    """Let the reader read the folder with these bytes in that file."""
    (here / file).write_bytes(data)
    found.inputs += 1
    try:
        reader.read(here)
    except HopslamError:
        found.refused += 1
    except Exception:  # noqa: BLE001  # what must not come is what is looked for
        found.untamed.append(f"{label}: {file}: {traceback.format_exc()}")


def main(arguments: list[str]) -> int:
    """All readers, each with its share of the inputs; the exit code is 1 where one was not tamed."""
    inputs, seed = int(arguments[0]) if arguments else 5_000, int(arguments[1]) if len(arguments) > 1 else 1
    chosen = {name: reader for name, reader in READERS.items() if len(arguments) < 3 or name in arguments[2:]}
    share, total = max(inputs // sum(r.weight for r in chosen.values()), 1), 0
    print(f"{'reader':<16}{'inputs':>8}{'refused':>9}{'untamed':>9}{'s':>7}   seed {seed}")
    with TemporaryDirectory(prefix="hopslam-seeds-") as folder:
        for name, reader in chosen.items():
            seeds, began = reader.make(Path(folder) / name), time.perf_counter()
            runs: list[Callable[[], Failures]] = [
                lambda n=name, r=reader, s=seeds: try_cuts(n, r, s),  # type: ignore[misc]
                lambda n=name, r=reader, s=seeds: try_reader(n, r, s, share * r.weight, seed),  # type: ignore[misc]
            ]
            found = [run() for run in (runs if reader.cuts else runs[1:])]
            untamed = [text for one in found for text in one.untamed]
            total += len(untamed)
            counts = sum(f.inputs for f in found), sum(f.refused for f in found), len(untamed)
            print(
                f"{name:<16}{counts[0]:>8}{counts[1]:>9}{counts[2]:>9}{time.perf_counter() - began:>7.0f}", flush=True
            )
            for text in untamed[:3]:
                print(text)
    return 1 if total else 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
