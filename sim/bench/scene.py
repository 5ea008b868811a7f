"""The scene in which the simulator's speed is told: a corridor with 40 boxes."""

from __future__ import annotations

from typing import Literal

import numpy as np

from slam.scenario.schema import Scenario

SEED = 0


def corridor(caster: Literal["bullet", "exact"]) -> Scenario:
    """35 m by 4 m; 682 beams, rolling, with the noise of the paper, 10 scans and 240 physics steps a second."""
    rng = np.random.default_rng(SEED)
    boxes = [
        {
            "center": [2.0 + 0.78 * k, float(rng.choice([-1.0, 1.0]) * rng.uniform(1.2, 1.8))],
            "size": [*rng.uniform(0.3, 0.7, 2).tolist(), 0.6],
            "yaw": float(rng.uniform(-1.0, 1.0)),
        }
        for k in range(40)
    ]
    walls = [{"points": [[-1.5, -2.0], [33.5, -2.0], [33.5, 2.0], [-1.5, 2.0]], "closed": True}]
    return Scenario.model_validate(
        {"name": "bench", "world": {"walls": walls, "boxes": boxes}, "lidar": {"caster": caster}, "duration": 1e6}
    )
