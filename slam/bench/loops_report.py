"""``hopslam bench loops``: benefit and cost of loop closing."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from slam.bench.loops.block_table import block_table
from slam.bench.loops.log_tables import log_tables
from slam.bench.loops.sim_tables import hour_tables, sim_tables
from slam.bench.loops.stress_table import stress_table
from slam.config import SlamConfig
from slam.console.result_table import ResultTable
from slam.console.terminal import Terminal
from slam.errors import InputError, did_you_mean
from slam.scenario.file import load_scenario

NOISY_RUNS: Final = 8
"""Runs of a log with noise on its ranges."""
DRIVES: Final = 10
"""Drives around each loop in the simulator, with and without loop closing."""
STRESSED_RUNS: Final = 5
"""Runs of each variant of a log."""


@dataclass(frozen=True, slots=True)
class LoopBench:
    """Selection of the measurements."""

    folder: Path
    """Folder of the recorded logs."""
    logs: Sequence[str] = ()
    """Names of logs; empty for those of the project's tables."""
    variants: Sequence[str] = ()
    """Variants of the logs; empty for those of the project's table."""
    seeds: int | None = None
    """Number of repeated runs; None for NOISY_RUNS, DRIVES and STRESSED_RUNS."""
    settings: tuple[str, ...] = ()
    console: Terminal = field(default_factory=lambda: Terminal(quiet=True))

    def log_tables(self) -> list[ResultTable]:
        """Measure recorded logs: their errors, loops and costs."""
        return log_tables(self.logs, self.folder, self._runs(NOISY_RUNS), self._config, self.console)

    def stress_tables(self) -> list[ResultTable]:
        """Measure variants of logs that are harder."""
        runs = self._runs(STRESSED_RUNS)
        return stress_table(self.logs, self.folder, self.variants, runs, self._config, self.console)

    def sim_tables(self) -> list[ResultTable]:
        """Measure drives around loops in the simulator."""
        return sim_tables(self._runs(DRIVES), self.settings, self.console)

    def block_tables(self) -> list[ResultTable]:
        """Measure the generated building of 2 km."""
        return [block_table(0, self._config, self.console)]

    def hour_tables(self) -> list[ResultTable]:
        """Measure one hour around one loop."""
        with self.console.waiting("driving around a loop for one simulated hour"):
            return hour_tables(self.settings)

    def _runs(self, usual: int) -> int:
        return usual if self.seeds is None else self.seeds

    @property
    def _config(self) -> SlamConfig:
        return load_scenario("replay", list(self.settings)).slam


PARTS: Final[dict[str, Callable[[LoopBench], list[ResultTable]]]] = {
    "logs": LoopBench.log_tables,
    "sim": LoopBench.sim_tables,
    "blocks": LoopBench.block_tables,
    "stress": LoopBench.stress_tables,
    "hour": LoopBench.hour_tables,
}
"""The parts of the benchmark by their names."""
DEFAULT_PARTS: Final = ("logs", "sim", "blocks")


def loop_tables(parts: Sequence[str], bench: LoopBench) -> Iterator[ResultTable]:
    """Measure these parts, or DEFAULT_PARTS, one after the other; InputError for an unknown one."""
    for part in parts:
        if part not in PARTS:
            hint = did_you_mean(part, list(PARTS), otherwise=f"one of {', '.join(PARTS)}")
            raise InputError(f"no part {part!r}; {hint}")
    for part in parts or DEFAULT_PARTS:
        yield from PARTS[part](bench)
