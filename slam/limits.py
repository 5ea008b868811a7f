"""Limits of all inputs, each with its reason; docs/limits.md lists them.

A limit is far above the output of robots and their recorders, and far below the memory of a small computer.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

_MIB: Final = 1 << 20


@dataclass(frozen=True, slots=True)
class Limit:
    """The largest number of one thing."""

    most: int
    unit: str
    """The counted thing, in the plural."""
    reason: str

    def excess(self, found: float, of: str = "") -> str | None:
        """Describe in one clause that ``found`` exceeds the limit, with its reason; None if it does not.

        ``of`` names what was counted, such as ``in one chunk``.
        """
        if found <= self.most:
            return None
        counted = f"{round(found):,}" if found < 1e18 else f"{found:.3g}"
        where = f" {of}" if of else ""
        return f"{counted} {self.unit}{where}, over the limit of {self.most:,}: {self.reason} (see docs/limits.md)"


CHUNK: Final = Limit(64 * _MIB, "bytes", "recorders close a chunk at 1 to 16 MB, and one is in memory as a whole")
UNPACKED_AT_ONCE: Final = Limit(64 * _MIB, "unpacked bytes", "so little does no harm, even from a file of a few bytes")
UNPACKED_PER_BYTE: Final = Limit(
    1_000, "times the packed size", "a scan packs to a fifth of its size, that of a standing robot to a 300th"
)
UNPACKED: Final = Limit(100_000 * _MIB, "unpacked bytes", "a day of a fast lidar, with the pictures of a camera")
BEAMS: Final = Limit(50_000, "beams a scan", "the finest planar lidars have 25,200")
SCANS: Final = Limit(5_000_000, "scans a log", "a day at 50 Hz; stamps and poses of all are in memory")
FROM_START: Final = Limit(100_000, "metres from the start", "no indoor robot drives so far on one battery")
STEP: Final = Limit(10, "metres a step beyond 15 m/s", "no wheeled robot is faster, so the pose is garbled")
LINE: Final = Limit(256 * 1024, "bytes a line", "a scan of 682 beams takes 4,096; what is beyond is dropped")
MAP_CELLS: Final = Limit(50_000_000, "cells", "a square of 1.4 km at 20 cm, which takes 200 MB")
ROS_MAP_CELLS: Final = Limit(20_000_000, "cells", "a square of 220 m at 5 cm, which takes 200 MB")
PIXELS: Final = Limit(25_000_000, "pixels", "a square of 250 m at 5 cm, which takes 100 MB")
SOLIDS: Final = Limit(200_000, "rectangles", "a noisy map of a large building has 20,000")
YAML_SIZE: Final = Limit(256 * 1024, "bytes", "the config.yaml of the largest shipped scenario has 27,000")
YAML_NODES: Final = Limit(
    100_000, "keys and values, each alias counted with all that it stands for", "a few bytes can stand for gigabytes"
)
YAML_DEPTH: Final = Limit(64, "levels of lists and mappings", "scenarios have 8")
YAML_DIGITS: Final = Limit(1_000, "digits of a number", "a float has 17")
JSON_SIZE: Final = Limit(512 * _MIB, "bytes", "a map of a million surfels has 200 MB")
RUNS: Final = Limit(1_000_000, "runs of a sweep", "a run takes a second or more; they are counted before any is made")
CASES: Final = Limit(10_000, "cases of a sweep", "each is checked before the first run, and has a row in the tables")

LIMITS: Final[dict[str, Limit]] = {
    "Bytes of one chunk or message of a bag": CHUNK,
    "Unpacked bytes up to which any packing ratio is allowed": UNPACKED_AT_ONCE,
    "Packing ratio of a larger file: unpacked bytes per packed byte": UNPACKED_PER_BYTE,
    "Unpacked bytes of any file": UNPACKED,
    "Bytes of a line of a text log": LINE,
    "Beams of a scan": BEAMS,
    "Scans of a log": SCANS,
    "Metres between a pose of a log and its start": FROM_START,
    "Metres between two poses of a log, beyond those that 15 m/s explains": STEP,
    "Cells of a map": MAP_CELLS,
    "Cells of an occupancy map that is exported": ROS_MAP_CELLS,
    "Pixels of a map's picture": PIXELS,
    "Rectangles of a map's picture": SOLIDS,
    "Bytes of a YAML file": YAML_SIZE,
    "Keys and values of a YAML file, its aliases written out": YAML_NODES,
    "Depth of a YAML file": YAML_DEPTH,
    "Digits of a number in YAML": YAML_DIGITS,
    "Bytes of a JSON file": JSON_SIZE,
    "Runs of a sweep": RUNS,
    "Cases of a sweep: inputs, modes and grid": CASES,
}
"""Every limit, by the thing it limits."""


def table() -> str:
    """Return the table of docs/limits.md, in Markdown."""
    rows = [f"| {name} | {limit.most:,} | {limit.reason} |" for name, limit in LIMITS.items()]
    return "\n".join(["| limit | most | because |", "|---|---|---|", *rows]) + "\n"
