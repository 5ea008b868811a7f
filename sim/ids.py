"""The ids under which gymnasium knows the simulated robot."""

from __future__ import annotations

from typing import Final

GENERAL_ID: Final = "hopslam/P3DX-v0"
"""Any scenario, by its argument ``scenario``."""

SCENARIO_IDS: Final = {
    "hopslam/ClutteredRoom-v0": "cluttered_room",
    "hopslam/Corridor-v0": "corridor",
    "hopslam/CrowdedCorridor-v0": "crowded_corridor",
    "hopslam/FeaturelessCorridor-v0": "featureless_corridor",
    "hopslam/OfficeLoop-v0": "office_loop",
    "hopslam/PaperCorridor-v0": "paper_corridor",
    "hopslam/PaperSimulation-v0": "paper_simulation",
    "hopslam/RandomOffice-v0": "random_office",
    "hopslam/UmbmarkRoom-v0": "umbmark_room",
}
"""One for each shipped scenario that has a world to drive in."""
