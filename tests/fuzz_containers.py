"""Feed damaged files to every reader: ``python -m tests.fuzz_containers [INPUTS [SEED [READER...]]]``.

Whatever the file, a reader may raise only an error of slam.errors. Each reader gets valid files of its kind, cut at
every byte, and with bits and bytes changed, dropped and doubled; an input is made again from reader, seed and number.
"""

import random
import sys
import time
import traceback
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory

from slam.errors import HopslamError
from tests.fuzz_seeds import READERS, Reader

_JUNK = (b"\xff", b"\0", b"-1", b"9" * 30, b"nan", b"[" * 2000, b"\xff" * 7 + b"\x7f", b"\n", b'"', b"{}")
_CUTS = 1000
"""Places at which a file is cut; a smaller one at every byte."""


@dataclass
class Findings:
    """The outcomes of the inputs of one reader, counted."""

    inputs: int = 0
    refused: int = 0
    unexpected: list[str] = field(default_factory=list)
    """Label and traceback of each other exception."""


def damaged(whole: bytes, rng: random.Random) -> bytes:
    """Return the bytes with one to four random faults, or truncated."""
    data = bytearray(whole)
    if rng.random() < 0.2:
        return bytes(data[: rng.randrange(len(data) + 1)])
    for _ in range(rng.randrange(1, 5)):
        at, kind = rng.randrange(len(data) + 1), rng.randrange(5)
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


def inputs_of(
    name: str, files: dict[str, bytes], count: int, seed: int, most_cuts: int
) -> Iterator[tuple[str, str, bytes]]:
    """Yield label, file and bytes: at most ``most_cuts`` truncated files, and ``count`` damaged ones."""
    for file, whole in files.items():
        for end in range(0, len(whole), max(len(whole) * len(files) // max(most_cuts, 1), len(whole) // _CUTS, 1)):
            yield f"{name} cut at {end}", file, whole[:end]
    for number in range(count):
        label = f"{name} {seed} {number}"
        rng = random.Random(label)
        file = rng.choice(list(files))
        yield label, file, damaged(files[file], rng)


def feed_all(name: str, reader: Reader, seeds: Path, count: int, seed: int, most_cuts: int = 10**6) -> Findings:
    """Feed the reader ``count`` damaged files, and truncated ones."""
    found = Findings()
    files = {file: (seeds / file).read_bytes() for file in reader.files(seeds)}
    with TemporaryDirectory(prefix="hopslam-fuzz-") as folder:
        here = reader.copy(seeds, Path(folder) / "here")
        for label, file, data in inputs_of(name, files, count, seed, most_cuts if reader.cuts else 0):
            (here / file).write_bytes(data)
            _feed(found, reader, here, file, label)
            reader.restore(seeds, here, file)
    return found


def _feed(found: Findings, reader: Reader, here: Path, file: str, label: str) -> None:
    found.inputs += 1
    try:
        reader.read(here, file)
    except HopslamError:
        found.refused += 1
    except Exception:  # noqa: BLE001  # the test looks for any exception that is not a HopslamError
        found.unexpected.append(f"{label}: {file}: {traceback.format_exc()}")


def main(arguments: list[str]) -> int:
    """Run all readers, each with its share of the inputs; the exit code is 1 after an unexpected exception."""
    count, seed = (int(word) for word in [*arguments[:2], *("5000", "1")[len(arguments) :]])
    chosen = {name: reader for name, reader in READERS.items() if name in (arguments[2:] or READERS)}
    unexpected, weights = 0, sum(reader.weight for reader in chosen.values())
    print(f"{'reader':<16}{'inputs':>8}{'refused':>9}{'unexpected':>9}{'s':>7}   seed {seed}", flush=True)
    with TemporaryDirectory(prefix="hopslam-seeds-") as folder:
        for name, reader in chosen.items():
            seeds, began = reader.make(Path(folder) / name), time.perf_counter()
            found = feed_all(name, reader, seeds, count * reader.weight // weights, seed)
            unexpected += len(found.unexpected)
            row = f"{name:<16}{found.inputs:>8}{found.refused:>9}{len(found.unexpected):>9}"
            print("\n".join([f"{row}{time.perf_counter() - began:>7.0f}", *found.unexpected[:3]]), flush=True)
    return 1 if unexpected else 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
