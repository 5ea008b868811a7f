"""``hopslam bench paper``: everything measured, drawn and written into a folder."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Final

from slam.bench.paper import fig_7, fig_8, fig_10, table_2, tables
from slam.console.result_table import ResultTable
from slam.console.terminal import Terminal
from slam.errors import InputError
from slam.files.whole_files import write_whole
from slam.named_code import import_optional

QUICK_POINTS: Final = 380
QUICK_TRIALS: Final = 20
TRIALS: Final = 200


@dataclass(frozen=True, slots=True)
class PaperReport:
    """What came out, and where it is."""

    tables: tuple[ResultTable, ...]
    path: Path
    """The Markdown report; the pictures are beside it."""


def reproduce(out: Path, quick: bool, console: Terminal) -> PaperReport:
    """Measure Table 2 and Figs. 7, 8 and 10 and write ``report.md`` and their pictures into ``out``.

    Quick: with fewer points and trials, as the report then says. InputError when ``out`` cannot be written or
    scikit-image is missing.
    """
    import_optional("skimage.transform", "bench")  # before minutes of work
    _make(out)
    count, trials = (QUICK_POINTS, QUICK_TRIALS) if quick else (table_2.POINTS, TRIALS)
    with console.progress() as bar:
        task = bar.add_task(f"Table 2, {count} points", total=1.0)
        rows_2 = table_2.measure(count, lambda share: bar.advance(task, share))
        rows_7 = list(bar.track(fig_7.measure(trials), total=len(fig_7.PSI), description="Fig. 7"))
    with console.waiting("Fig. 8"):
        result_8 = fig_8.measure()
    with console.waiting("drawing"):
        fig_7.draw(rows_7, out / "fig_7.png")
        fig_8.draw(result_8, out / "fig_8.png")
        fig_10.draw(out / "fig_10.png")
    found = (
        tables.table_2(rows_2, count),
        tables.figure_7(rows_7, trials),
        tables.figure_8(result_8),
        tables.figure_10(),
    )
    return PaperReport(found, _write(out, found))


def _write(out: Path, found: tuple[ResultTable, ...]) -> Path:
    pictures = ("", "fig_7.png", "fig_8.png", "fig_10.png")
    parts = ["# The paper's numbers, measured again\n\n"]
    for table, picture in zip(found, pictures, strict=True):
        parts.append(table.markdown() + (f"![{table.title}]({picture})\n\n" if picture else ""))
    path = out / "report.md"
    write_whole(path, "".join(parts).rstrip() + "\n")
    return path


def _make(out: Path) -> None:
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{out}: cannot be made: {error.strerror}; choose another --out DIR") from error
