"""Every figure of a run as PNG and PDF, for papers: those of the report, and the paper's own."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

from matplotlib.figure import Figure

from slam.files.atomic_files import atomic_file
from slam.run.pictures.error_curves import paper_curves
from slam.run.pictures.figure_style import save_figure
from slam.run.pictures.map_picture import contents_of, contents_without_loops, map_figure
from slam.run.report.paper_maps import fig_15, fig_16, fig_21, scan_points
from slam.run.report.run_plots import distance_figure, error_figure, iterations_figure, timing_figure
from slam.run.results.run_record import RunRecord

_DPI: Final = 200
_METADATA: Final = {"png": {"Software": None}, "pdf": {"CreationDate": None}}
"""Makes the files reproducible: the same run, the same bytes."""


def write_figures(records: Sequence[RunRecord], folder: Path) -> int:
    """Write the figures, for several runs each into its own folder; return their number."""
    count = 0
    for number, record in enumerate(records, 1):
        own = folder if len(records) == 1 else folder / f"{number}-{record.name}"
        own.mkdir(parents=True, exist_ok=True)
        for name, figure in run_figures(record):
            for kind, metadata in _METADATA.items():
                with atomic_file(own / f"{name}.{kind}") as draft:
                    save_figure(figure, draft, format=kind, dpi=_DPI, metadata=metadata)
            count += 1
    return count


def run_figures(record: RunRecord) -> Iterator[tuple[str, Figure]]:
    """Yield figures by the names of their files; those that need the true pose only if it is known."""
    traces = record.traces
    yield "map", map_figure(contents_of(record), longest=8.0)
    if (before := contents_without_loops(record)) is not None:
        yield "map_without_loops", map_figure(before, longest=8.0)
    yield "errors", error_figure(traces)
    if (distance := distance_figure([("", traces)])) is not None:
        yield "distance", distance
    yield "iterations", iterations_figure([("iterations", traces)])
    yield "timing", timing_figure([("", traces)])
    scans = scan_points(record)
    if scans.scans:
        yield "fig15", fig_15(record, scans)
        yield "fig16", fig_16(record, scans)
    yield from paper_curves(traces)
    yield "fig21", fig_21(record, scans)
