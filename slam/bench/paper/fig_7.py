"""Fig. 7: over-hopping, which does not happen.

sigma_3 cannot fall when a point is added; so the test after a hop fails even if the hop leaps over the end of a segment
and over the whole next one, and the reverse hop finds the end.

The module counts how often the segments with hops differ from those without, and how many tests of sigma_3 they need.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from matplotlib.figure import Figure

from slam.bench.paper.table_2 import SIGMA_TH, tested_lengths
from slam.lines.hopping import hop_by_svd, sigma_3
from slam.pose import FloatArray, unit_vectors
from slam.run.pictures.figure_style import PAPER, save_figure

PSI: Final = (0, 1, 2, 3, 5, 7, 10, 15, 25, 40)
NOISE: Final = 0.002
MEAN_TH: Final = 0.003
"""Metres: threshold on sigma_3 / sqrt(l), for comparison."""


@dataclass(frozen=True, slots=True)
class Fig7Row:
    """Result of one hopping factor over all trials."""

    psi: int
    different: int
    """Trials in which the segments differ from those without hopping."""
    tests: float
    """Tests per trial, on average."""
    different_mean: int
    """The same count for a threshold on sigma_3 / sqrt(l), which an additional point may lower."""


def step_wall(seed: int) -> FloatArray:
    """Make Fig. 7's scene: a long S1, a short S2 of 4 to 11 points and a long S3; points 2 cm apart, (N, 2), metres."""
    random = np.random.default_rng(seed)
    counts = np.array([40, random.integers(4, 12), 40])
    headings = np.cumsum([0.0, *(random.uniform(0.4, 1.5, 2) * random.choice([-1.0, 1.0], 2))])
    steps = np.repeat(unit_vectors(headings), counts, axis=0)
    points = np.array([-0.8, 1.0]) + 0.02 * np.cumsum(steps, axis=0)
    return np.asarray(points + random.normal(0.0, NOISE, points.shape))


def measure(trials: int = 200) -> Iterator[Fig7Row]:
    """Count for one hopping factor after the other."""
    walls = [step_wall(seed) for seed in range(trials)]
    plain = [hop_by_svd(wall, SIGMA_TH, 0) for wall in walls]
    plain_mean = [hop_by_svd(wall, MEAN_TH, 0, mean_sigma_3) for wall in walls]
    for psi in PSI:
        found = [hop_by_svd(wall, SIGMA_TH, psi) for wall in walls]
        found_mean = [hop_by_svd(wall, MEAN_TH, psi, mean_sigma_3) for wall in walls]
        tests = np.mean([len(tested_lengths(wall, SIGMA_TH, psi)) for wall in walls])
        yield Fig7Row(psi, _differing(found, plain), float(tests), _differing(found_mean, plain_mean))


def mean_sigma_3(points: FloatArray) -> float:
    """Return sigma_3 / sqrt(l), metres, which is not the paper's test."""
    return sigma_3(points) / float(np.sqrt(len(points)))


def _differing(found: Sequence[object], plain: Sequence[object]) -> int:
    return sum(a != b for a, b in zip(found, plain, strict=True))


def draw(rows: Sequence[Fig7Row], path: Path, psi: int = 25) -> None:
    """Draw a hop over S2 on the scene and on the curve of sigma_3, and the number of tests over psi."""
    wall = step_wall(seed=3)
    lengths = np.arange(3, len(wall) + 1)
    sigma = np.array([sigma_3(wall[:l]) for l in lengths])
    landings = np.arange(3, len(wall) + 1, psi + 1)
    refused = landings[np.argmax(sigma[landings - 3] >= SIGMA_TH)]
    landings = landings[landings <= refused]
    end = lengths[sigma < SIGMA_TH][-1]
    figure = Figure(figsize=(14, 4.5), dpi=110, layout="constrained")
    scene, curve, counts = figure.subplots(1, 3)
    scene.plot(*wall.T, ".", color="0.6", markersize=4)
    scene.plot(*wall[landings - 1].T, "o", color=PAPER.odometry, markerfacecolor="none", label=f"hops, psi = {psi}")
    scene.plot(*wall[end - 1], "*", color=PAPER.accent, markersize=12, label="end found by the reverse hop")
    scene.set(title="(a) a hop lands beyond the short S2", xlabel="x [m]", ylabel="y [m]", aspect="equal")
    curve.semilogy(lengths, sigma, color=PAPER.slam)
    curve.axhline(SIGMA_TH, color="0.5", linestyle="--", label="threshold")
    curve.plot(landings, sigma[landings - 3], "o", color=PAPER.odometry, markerfacecolor="none")
    curve.plot(end, sigma[end - 3], "*", color=PAPER.accent, markersize=12)
    curve.set(title="(b) sigma_3 never falls", xlabel="points l", ylabel="sigma_3 [m]")
    counts.plot([row.psi for row in rows], [row.tests for row in rows], "o-", color=PAPER.slam)
    counts.set(title="(c) what a large psi costs", xlabel="psi", ylabel="tests a scan", ylim=(0, None))
    for axes in (scene, curve):
        axes.legend(fontsize="small")
    save_figure(figure, path)
