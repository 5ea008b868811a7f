"""``hopslam bench paper``: everything measured, drawn and written into a folder."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from slam.bench.paper import fig_3, fig_7, fig_8, fig_10, fig_21, table_2, tables
from slam.console.result_table import ResultTable
from slam.console.terminal import Terminal
from slam.files.atomic_files import atomic_file, require_writable, write_atomic
from slam.named_code import import_optional

QUICK_POINTS: Final = 380
QUICK_TRIALS: Final = 80
QUICK_DURATION: Final = 10.0
"""Seconds that the robot drives along the corridor of Fig. 21; without --quick, to the end and back."""
TRIALS: Final = 200
_REMEDY: Final = "make room, or choose another --out DIR"


@dataclass(frozen=True, slots=True)
class PaperReport:
    """Tables of the measurements, and their report."""

    tables: tuple[ResultTable, ...]
    path: Path
    """The Markdown report; the pictures are beside it."""


def reproduce(out: Path, quick: bool, console: Terminal) -> PaperReport:
    """Measure Table 2, Figs. 3, 7, 8 and 10 and the time of Fig. 21; write ``report.md`` and the pictures into ``out``.

    ``quick`` uses fewer points and trials and a shorter drive, and the report states that. InputError if ``out`` cannot
    be written or scikit-image is missing, StorageError if the disk fails.
    """
    import_optional("skimage.transform", "bench")  # fails before the long measurement
    with require_writable(out, _REMEDY):
        out.mkdir(parents=True, exist_ok=True)
    count, trials = (QUICK_POINTS, QUICK_TRIALS) if quick else (table_2.POINTS, TRIALS)
    with console.progress() as bar:
        task = bar.add_task(f"Table 2, {count} points", total=1.0)
        rows_2 = table_2.measure(count, lambda share: bar.advance(task, share))
        rows_7 = list(bar.track(fig_7.measure(trials), total=len(fig_7.PSI), description="Fig. 7"))
    with console.waiting("Figs. 3 and 8"):
        result_3, result_8 = fig_3.measure(), fig_8.measure()
    with console.waiting("Fig. 21: a run along the corridor"):
        result_21 = fig_21.measure(QUICK_DURATION if quick else None)
    drawings: dict[str, Callable[[Path], None]] = {
        "fig_3.png": lambda path: fig_3.draw(result_3, path),
        "fig_7.png": lambda path: fig_7.draw(rows_7, path),
        "fig_8.png": lambda path: fig_8.draw(result_8, path),
        "fig_10.png": fig_10.draw,
        "fig_21.png": lambda path: fig_21.draw(result_21, path),
    }
    found = {
        "": tables.table_2(rows_2, count),
        "fig_3.png": tables.figure_3(result_3),
        "fig_7.png": tables.figure_7(rows_7, trials),
        "fig_8.png": tables.figure_8(result_8),
        "fig_10.png": tables.figure_10(),
        "fig_21.png": tables.figure_21(result_21),
    }
    with require_writable(out, _REMEDY), console.waiting("drawing"):
        return PaperReport(tuple(found.values()), _write(out, found, drawings))


def _write(out: Path, found: dict[str, ResultTable], drawings: dict[str, Callable[[Path], None]]) -> Path:
    """Draw the pictures, and write the report: each table, followed by its picture if it has one."""
    for name, draw in drawings.items():
        with atomic_file(out / name) as draft:
            draw(draft)
    text, path = "# The paper's numbers, measured again\n\n", out / "report.md"
    for picture, table in found.items():
        text += table.markdown() + (f"![{table.title}]({picture})\n\n" if picture else "")
    write_atomic(path, text.rstrip() + "\n")
    return path
