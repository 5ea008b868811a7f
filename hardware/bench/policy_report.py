"""The table of ``hopslam bench policy``."""

from collections.abc import Callable, Sequence

import numpy as np

from hardware.bench.policy import make_policy
from hardware.bench.policy_scores import Score, score_alone, score_in_batch, score_on_devices
from slam.console.result_table import ResultTable
from slam.console.terminal import Terminal
from slam.scenario.clock import installed_engine


def policy_table(name: str, seeds: range, on_devices: int, console: Terminal) -> ResultTable:
    """Score a policy in every simulator with these seeds, and on emulated devices with the first ``on_devices``.

    Without PyBullet its rows are left out, and the notes say so.
    """
    policy = make_policy(name)
    first, rows = seeds[:on_devices], []
    places: dict[str, Callable[[], list[Score]]] = {
        "batch": lambda: score_in_batch(policy, seeds),
        "physics.engine: plan": lambda: score_alone(policy, seeds, "plan"),
        "PyBullet": lambda: score_alone(policy, seeds, "bullet"),
        "PyBullet, only the seeds of devices": lambda: score_alone(policy, first, "bullet"),
        "devices, moved by plan": lambda: score_on_devices(policy, first, "plan"),
        "devices, moved by PyBullet": lambda: score_on_devices(policy, first, "sim"),
    }
    left_out = [place for place in places if "PyBullet" in place and installed_engine() == "plan"]
    for place in left_out:
        del places[place]
    with console.progress(still=True) as bar:
        for place, score in bar.track(places.items(), len(places), description=name):
            rows.append(_row(place, score()))
    columns = ("", "episodes", "return\nmean", "least", "most", "seconds\nmean", "collisions", "goals")
    notes = (
        "All rows have the same seeds. For the batch as many worlds as robots are prepared, and a seed selects one of "
        "them; elsewhere a seed generates the world. Devices run in real time; there, rewards, ends and the goal come "
        "from SLAM."
    )
    if left_out:
        notes += f" PyBullet is not installed (pip install pybullet); left out: {'; '.join(left_out)}."
    return ResultTable(f"The policy {name} in {policy.env_id}", columns, rows, notes)


def _row(place: str, scores: Sequence[Score]) -> tuple[str, ...]:
    if not scores:
        return (place, "0", *[""] * 6)
    earned = np.array([score.earned for score in scores])
    endings = [score.ending for score in scores]
    seconds = np.mean([score.seconds for score in scores])
    counts = (str(endings.count(ending)) for ending in ("collision", "goal"))
    figures = (earned.mean(), earned.min(), earned.max(), seconds)
    return (place, str(len(scores)), *(f"{figure:.2f}" for figure in figures), *counts)
