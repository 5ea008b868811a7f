"""The settings of the whole method: extractor, map and matcher, and when they are used."""

from typing import Any, Literal, Self

from pydantic import Field, model_validator

from slam.config.lines import ChiSquareConfig, LineConfig
from slam.config.localization import LocalizationConfig
from slam.config.mapping import MapConfig, SurfelMapConfig
from slam.config.matching import LeastSquaresConfig, MatchConfig
from slam.config.section import OwnMethod, Section
from slam.modes import MODES, ModeName


class SlamConfig(Section):
    """The whole method, Fig. 14 of the paper.

    By default it is this project's own; ``mode: paper`` selects the paper's, and ``mode: dead_reckoning`` wheel
    odometry alone, for comparison.
    """

    mode: ModeName = "hopslam"
    """Default methods of the three parts below."""
    lines: LineConfig = ChiSquareConfig()
    """Extraction of lines from a scan."""
    map: MapConfig = SurfelMapConfig()
    """Map made of the scans."""
    matching: MatchConfig = LeastSquaresConfig()
    """Matching of a scan to the map."""
    localization: LocalizationConfig = LocalizationConfig()
    loops: Literal["auto", "never"] = "auto"
    """Closing of loops: ``auto`` searches for known places whenever a submap is finished, and corrects pose and map;
    ``never`` keeps the map as it was first seen. Only this project's own matcher and map close loops."""
    deskew: bool = True
    """Correct for the motion of the robot during a scan, if its beams have times; off in paper mode."""
    odometry: bool = True
    """Start matching from odometry, eqs. (38)-(44); if false, from the last pose, as in the paper's simulation."""
    update_distance: float = Field(0.0, ge=0)
    """Extract, match and map only after this much motion since the last time, metres; odometry covers the scans
    between. At 0 every scan is used."""
    update_angle: float = Field(0.2, gt=0)
    """Extract, match and map also after this much turning, radians, if ``update_distance`` is above 0."""

    def without_odometry(self) -> Self:
        """Return these settings for scans without odometry: every scan is used, as no motion is known."""
        return self.model_copy(update={"odometry": False, "update_distance": 0.0})

    @model_validator(mode="before")
    @classmethod
    def _methods_of_the_mode(cls, given: Any) -> Any:
        if not isinstance(given, dict) or (name := str(given.get("mode", "hopslam"))) not in MODES:
            return given
        mode = MODES[name]
        methods = {"lines": mode.lines, "map": mode.map, "matching": mode.matching}
        parts = {part: _with_method(given.get(part, {}), method) for part, method in methods.items()}
        return {**mode.settings, **given, **parts}

    @model_validator(mode="after")
    def _steps_need_odometry(self) -> Self:
        if self.update_distance > 0 and not self.odometry:
            raise ValueError("update_distance needs odometry to measure it; set odometry: true, or leave it at 0")
        return self

    @model_validator(mode="after")
    def _map_and_matcher_fit(self) -> Self:
        if isinstance(self.matching, OwnMethod):
            return self
        if (self.map.method == "points") != (self.matching.method == "force_field"):
            raise ValueError(
                f"matching method {self.matching.method} does not work on map method {self.map.method}; force_field "
                f"goes with points, and least_squares with surfels"
            )
        return self


def _with_method(section: Any, method: str) -> Any:
    return {"method": method} | section if isinstance(section, dict) else section
