"""``hopslam bench match``: tables and picture."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from matplotlib.figure import Figure

from slam.bench.match_scenes import ScannedWorld
from slam.bench.match_score import (
    BEAMS,
    NEARBY,
    SHIFTS,
    TURNS,
    MatchRuns,
    convergence_basin,
    match_in_turns,
    start_poses,
)
from slam.bench.matchers import PaperMatcher, compared_matchers
from slam.console.result_table import ResultTable
from slam.console.terminal import Terminal
from slam.files.atomic_files import atomic_file
from slam.named_code import import_optional
from slam.pose import FloatArray
from slam.run.pictures.figure_style import PAPER, save_figure
from slam.scenario.schema import Scenario

PAPER_STEP: Final = 5
"""Every fifth place is used for the basin of the paper's matcher, which is slow."""


@dataclass(frozen=True, slots=True, eq=False)
class MatcherComparison:
    """Results of each matcher, by its name."""

    near: Mapping[str, Mapping[int, MatchRuns]]
    """Runs from starts nearby, by the number of beams."""
    basins: Mapping[str, FloatArray]
    """Share that converged, (turns, shifts), at 682 beams."""
    places: int


def compare_matchers(scenario: Scenario, places: int, seed: int, console: Terminal) -> MatcherComparison:
    """Run all matchers on the same scans; InputError if small_gicp is not installed."""
    import_optional("small_gicp", "bench")  # fails before the long measurement
    world = ScannedWorld(scenario, seed)
    with console.waiting("scanning"):
        made_from = world.map_scans()
        poses = world.places(places)
        scans = {beams: [world.scan(pose, beams) for pose in poses] for beams in BEAMS}
    matchers = compared_matchers(made_from)
    with console.waiting("timing"):
        races = {beams: match_in_turns(matchers, scans[beams], start_poses(*NEARBY)) for beams in BEAMS}
    near = {matcher.name: {beams: runs[matcher.name] for beams, runs in races.items()} for matcher in matchers}
    basins = {}
    with console.progress() as bar:
        for matcher in bar.track(matchers, description="basins"):
            few = scans[682][::PAPER_STEP] if isinstance(matcher, PaperMatcher) else scans[682]
            basins[matcher.name] = convergence_basin(matcher, few)
    return MatcherComparison(near, basins, places)


def match_tables(found: MatcherComparison) -> list[ResultTable]:
    """Tables of time, accuracy and basin of convergence."""
    return [_times(found), _accuracy(found), _basin(found)]


def _times(found: MatcherComparison) -> ResultTable:
    base = {beams: _milliseconds(runs) for beams, runs in found.near["ours"].items()}
    rows = [
        [name, *(f"{_milliseconds(runs):.2f} ({_milliseconds(runs) / base[beams]:.1f})" for beams, runs in row.items())]
        for name, row in found.near.items()
    ]
    return ResultTable(
        f"Time of one match, median in ms (and its ratio to ours), {found.places} places",
        ["points"] + [str(beams) for beams in BEAMS], rows,
        "Each time is for one scan on one thread. Ours and the paper's include the extraction of lines; those of "
        "small_gicp include its point cloud, and that of GICP also the covariances of the cloud. Maps, trees and "
        "normals are made before.",
    )  # fmt: skip


def _accuracy(found: MatcherComparison) -> ResultTable:
    rows = []
    for name, by_beams in found.near.items():
        errors = by_beams[682].errors
        rows.append([
            name,
            f"{1e3 * np.median(errors[:, 0]):.1f}", f"{1e3 * np.percentile(errors[:, 0], 90):.1f}",
            f"{np.degrees(np.median(errors[:, 1])):.3f}", f"{np.degrees(np.percentile(errors[:, 1], 90)):.3f}",
            f"{100 * by_beams[682].converged:.0f} %",
        ])  # fmt: skip
    return ResultTable(
        f"Accuracy at 682 points, from starts {NEARBY[0]:g} m and {NEARBY[1]:g} rad off",
        ["", "median,\nmm", "90 %,\nmm", "median,\ndeg", "90 %,\ndeg", "converged"], rows,
        "Converged: within 3 cm and 1 deg of the truth.",
    )  # fmt: skip


def _basin(found: MatcherComparison) -> ResultTable:
    rows = [
        [f"{name}, {turn:g} rad", *(f"{100 * share:.0f}" for share in shares)]
        for name, table in found.basins.items()
        for turn, shares in zip(TURNS, table, strict=True)
        if turn in (0.0, 0.2, 0.5)
    ]
    return ResultTable(
        "Basin at 682 points: converged, %, by how far the start is off",
        ["metres"] + [f"{shift:g}" for shift in SHIFTS], rows,
        f"Four directions at each of the {found.places} places; the paper's matcher is tested at every fifth place.",
    )  # fmt: skip


def _milliseconds(runs: MatchRuns) -> float:
    return 1e3 * float(np.median(runs.seconds))


def draw_comparison(path: Path, found: MatcherComparison) -> None:
    """Draw time over points, and a basin for each matcher, as a picture."""
    figure = Figure(figsize=(13, 6.5), dpi=130, layout="constrained")
    panels = figure.subplots(2, 4)
    times = panels[0, 0]
    for k, (name, by_beams) in enumerate(found.near.items()):
        colour, dash = PAPER.curve(k)
        milliseconds = [_milliseconds(runs) for runs in by_beams.values()]
        times.loglog(BEAMS, milliseconds, dash, marker="o", color=colour, label=name, markersize=3)
    times.set(xlabel="points", ylabel="time [ms]", title="time of one match")
    times.legend(fontsize=6)
    places = [*panels[0, 1:], *panels[1]]
    for axes, (name, shares) in zip(places, found.basins.items(), strict=False):
        image = axes.imshow(100 * shares, origin="lower", vmin=0, vmax=100, aspect="auto", cmap="viridis")
        axes.set_xticks(range(len(SHIFTS)), [f"{shift:g}" for shift in SHIFTS])
        axes.set_yticks(range(len(TURNS)), [f"{turn:g}" for turn in TURNS])
        axes.set(title=name, xlabel="start off [m]", ylabel="[rad]")
    figure.colorbar(image, ax=panels, label="converged [%]")
    for axes in places[len(found.basins) :]:
        axes.set_visible(False)
    with atomic_file(path) as draft:
        save_figure(figure, draft, format="png")
