"""``hopslam bench lines``: the tables, with a progress bar while they are made."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from slam.bench import compare, log_score
from slam.bench.line_times import time_table
from slam.bench.methods import all_methods, ours_misled, told_the_noise
from slam.bench.scenes import HELD_OUT_SEEDS, NOISE_LEVELS, scenes
from slam.console.result_table import ResultTable
from slam.console.terminal import Terminal
from slam.errors import InputError
from slam.files.atomic_files import write_atomic
from slam.files.logs import read_log
from slam.run.log_lines import chi_square_config


def scene_tables(seeds: int, console: Terminal) -> list[ResultTable]:
    """A table for each level of noise, on the first so many held-out seeds of each family."""
    used = HELD_OUT_SEEDS[:seeds]
    tables = []
    with console.progress() as bar:
        for noise_level, noise in NOISE_LEVELS.items():
            methods = (*all_methods(noise_level, told_the_noise(noise)), *ours_misled(noise))
            seen = list(scenes(used, noise_level))
            task = bar.add_task(f"noise {noise_level}", total=len(seen))
            tables.append(compare.table(noise_level, compare.compare(seen, methods, partial(bar.advance, task)), used))
    with console.waiting("timing"):
        tables.append(time_table(seeds))
    return tables


def log_tables(path: Path, console: Terminal, sensor: str | None = None) -> list[ResultTable]:
    """The table of a recorded log, with ours for the noise of the sensor of that name where one is given."""
    methods = all_methods(ours=chi_square_config(sensor))
    log = read_log(path)
    console.print(log.report)
    with console.progress() as bar:
        task = bar.add_task(path.name, total=len(log_score.scans_of(log)))
        return [log_score.table(path.name, log, log_score.score_log(log, methods, partial(bar.advance, task)))]


def write_tables(path: Path, tables: Sequence[ResultTable], title: str = "Line extractors side by side") -> None:
    """The tables as Markdown; InputError when the file cannot be written."""
    text = f"# {title}\n\n" + "".join(table.markdown() for table in tables)
    try:
        write_atomic(path, text.rstrip() + "\n")
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}; choose another --out FILE") from error
