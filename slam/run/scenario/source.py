"""Where a scenario comes from: a YAML file, with settings given by hand on top."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from slam.errors import ScenarioError
from slam.run.scenario.settings import apply_settings, parse_setting
from slam.run.scenario.yaml_file import Location, YamlFile


class ScenarioSource:
    """The data of a scenario, and for each key the place it was written at."""

    def __init__(self, path: Path, settings: Sequence[str] = ()) -> None:
        self._file = YamlFile(path)
        overrides = [parse_setting(text) for text in settings]
        self._by_hand = [location for location, _ in overrides]
        self.folder = path.parent
        self.data: dict[str, Any] = self._file.data
        apply_settings(self.data, overrides)
        self.data.setdefault("name", path.stem)

    def error(self, location: Location, reason: str) -> ScenarioError:
        """One line that says what is wrong with the key at this path, and where it was written."""
        key = ".".join(map(str, location)) or "scenario"
        return ScenarioError(f"{self._place(location)}: {key}: {reason}")

    def _place(self, location: Location) -> str:
        by_hand = any(path[: len(location)] == location[: len(path)] for path in self._by_hand)
        return "--set" if by_hand else self._file.place(location)
