"""The ids under which gymnasium knows the simulated robot."""

from __future__ import annotations

from typing import Final

GENERAL_ID: Final = "hopslam/P3DX-v0"
"""Any scenario, by its argument ``scenario``."""

SCENARIO_IDS: Final = {
    "hopslam/Corridor-v0": "corridor",
    "hopslam/PaperSimulation-v0": "paper_simulation",
}
"""One for each shipped scenario that has a world to drive in."""
