"""Fig. 21: the share of matching and map update in the time of a run along the corridor, section 5.2."""

from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from slam.bench.stopwatch import seconds
from slam.config import HoppingConfig
from slam.console.terminal import Terminal
from slam.lines.hopping import segments_by_hopping
from slam.pose import FloatArray
from slam.run.experiment_setup import scenario_experiment
from slam.run.loop import run_loop
from slam.run.pictures.figure_style import PAPER, save_figure
from slam.run.step import Step
from slam.run.warm_up import warm_up
from slam.scenario.file import load_scenario

SCENARIO: Final = "paper_corridor"
PAPER_SECONDS: Final = 1453.2
PAPER_MATCHING_SECONDS: Final = 1302.0
PAPER_SHARE: Final = PAPER_MATCHING_SECONDS / PAPER_SECONDS
"""The paper's share, 0.896, which it rounds down to 89 %."""
KERNELS: Final = {"svd_full": "full U of eq. (7)", "svd": "singular values only", "prefix_sums": "prefix sums"}
"""Tests of sigma_3, by ``lines.kernel``: they find the same segments, so one run serves all three."""


@dataclass(frozen=True, slots=True, eq=False)
class Fig21:
    """Wall time of the method in one run, seconds."""

    scans: int
    """Number of all scans of the run."""
    matching: FloatArray
    """Matching and map update of every mapped scan, (K,)."""
    extraction: dict[str, FloatArray]
    """Line extraction of every mapped scan by each of KERNELS, (K,)."""
    prediction: float
    """Odometry alone, for the scans that were not mapped."""

    def total(self, kernel: str) -> float:
        """Total time of the run, seconds."""
        return float(self.matching.sum() + self.extraction[kernel].sum()) + self.prediction

    def share(self, kernel: str) -> float:
        """Share of matching and map update in the total, 0 to 1."""
        return float(self.matching.sum()) / self.total(kernel)


class _UpdateTimes:
    """Watcher that keeps the times of the method, and extracts the lines of every mapped scan by every kernel.

    It does so at once, so that other load on the machine slows all of them alike.
    """

    def __init__(self, lines: HoppingConfig) -> None:
        self._configs = {kernel: lines.model_copy(update={"kernel": kernel}) for kernel in KERNELS}
        self.scans = 0
        self.prediction = 0.0
        self.matching: list[float] = []
        self.extraction: dict[str, list[float]] = {kernel: [] for kernel in KERNELS}

    def on_step(self, step: Step) -> None:
        self.scans += 1
        estimate = step.estimate
        if not estimate.mapped:
            self.prediction += estimate.total_time
            return
        self.matching.append(estimate.total_time - estimate.extraction_time)
        points = step.observation.scan.points()
        for kernel, config in self._configs.items():
            self.extraction[kernel].append(seconds(partial(segments_by_hopping, points, config)))


def measure(duration: float | None = None) -> Fig21:
    """Drive the scenario for ``duration`` simulated seconds, or to its end."""
    scenario = load_scenario(SCENARIO, [] if duration is None else [f"duration={duration}"])
    lines = scenario.slam.lines
    assert isinstance(lines, HoppingConfig)
    warm_up(Terminal(quiet=True), scenario.slam)
    experiment, times = scenario_experiment(scenario), _UpdateTimes(lines)
    with closing(experiment.env):
        run_loop(experiment.env, experiment.slam, experiment.pilot, [times], scenario.seed)
    extraction = {kernel: np.array(taken) for kernel, taken in times.extraction.items()}
    return Fig21(times.scans, np.array(times.matching), extraction, times.prediction)


def draw(result: Fig21, path: Path) -> None:
    """Draw (a) the time of every mapped scan and (b) the shares, compared with the paper's."""
    figure = Figure(figsize=(12, 4.5), dpi=110, layout="constrained")
    steps, shares = figure.subplots(1, 2)
    steps.semilogy(1e3 * result.matching, color=PAPER.slam, label="matching and map update")
    for (kernel, name), style in zip(KERNELS.items(), ("-", "--", ":"), strict=True):
        steps.semilogy(1e3 * result.extraction[kernel], style, color=PAPER.odometry, label=f"lines: {name}")
    steps.set(title="(a) time of every mapped scan", xlabel="mapped scan", ylabel="ms")
    steps.legend(fontsize="small", loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=2, frameon=False)
    _draw_shares(shares, result)
    save_figure(figure, path)


def _draw_shares(axes: Axes, result: Fig21) -> None:
    names = ["the paper", *KERNELS.values()]
    percent = 100.0 * np.array([PAPER_SHARE, *map(result.share, KERNELS)])
    bars = axes.barh(names, percent, color=PAPER.slam, label="matching and map update")
    axes.bar_label(bars, fmt="%.1f %%", label_type="center", color="white")
    axes.barh(names, 100.0 - percent, left=percent, color=PAPER.odometry, label="all else")
    axes.invert_yaxis()
    axes.set(title="(b) share of the whole time", xlabel="%", xlim=(0.0, 100.0))
    axes.legend(fontsize="small", loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=2, frameon=False)
