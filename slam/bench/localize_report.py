"""The tables of ``hopslam bench localize``."""

from __future__ import annotations

from itertools import chain

import numpy as np

from slam.bench.localize_trials import MappedWorld, Stay, map_world, starts, trial
from slam.console.result_table import ResultTable
from slam.console.terminal import Terminal
from slam.run.warm_up import warm_up
from slam.scenario.schema import Scenario


def localization_table(scenario: Scenario, trials: int, seconds: float, seed: int, console: Terminal) -> ResultTable:
    """Map the scenario's world, set down and move so many robots in it, and sum up."""
    warm_up(console, scenario.slam, search=True)
    with console.waiting(f"mapping {scenario.name}"):
        world = map_world(scenario, scenario.slam)
    places = starts(world, np.random.default_rng(seed))
    with console.progress(transient=True) as bar:
        stays = [
            trial(world, (next(places), next(places)), seconds, seed + k)
            for k in bar.track(range(trials), description=scenario.name)
        ]
    relocate, moved = zip(*stays, strict=True)
    return ResultTable(
        f"Localisation in {scenario.name}, seed {scenario.seed}: {trials} trials of {seconds:g} s",
        ["", "right", "after, s", "95 %, s", "worst, s", "scans\nwrong", "in map,\nm", "true,\nm", "first,\nms",
         "scan,\nms"],
        [_row("set down", relocate), _row("moved", moved)],
        f"The map: {len(world.map)} surfels, by one run whose ATE was {_ate(world):.3f} m. Set down anywhere, then "
        "moved without being told. Right: at the end sure, and within 0.3 m and 5 deg; after: median of the simulated "
        "time to the scan since which it was so. Wrong: sure, and not within. In map: rmse of these scans against "
        "where the true pose lies in the map; then against the truth. First: wall time of the search in the whole map.",
    )  # fmt: skip


def _row(name: str, stays: tuple[Stay, ...]) -> list[str]:
    after = [stay.right_after for stay in stays if stay.right_after is not None]
    times = np.array([stay.times[0] for stay in stays])
    return [
        name,
        f"{len(after)} of {len(stays)}",
        *(f"{np.percentile(after, share):.1f}" if after else "-" for share in (50, 95, 100)),
        str(sum(stay.wrong for stay in stays)),
        _rmse(chain.from_iterable(stay.errors_in_map for stay in stays)),
        _rmse(chain.from_iterable(stay.errors for stay in stays)),
        f"{1e3 * np.median(times):.0f}",
        f"{1e3 * np.median(np.concatenate([stay.times for stay in stays])):.2f}",
    ]


def _rmse(errors: chain[float]) -> str:
    values = np.fromiter(errors, np.float64)
    return f"{np.sqrt(np.mean(values**2)):.3f}" if len(values) else "-"


def _ate(world: MappedWorld) -> float:
    return float(np.sqrt(np.mean(np.sum((world.estimate - world.truth)[:, :2] ** 2, axis=1))))
