"""Input of a sweep: a scenario or a recorded log, with the settings that each mode needs."""

import json
from dataclasses import dataclass
from hashlib import file_digest, sha256
from pathlib import Path
from typing import Any, Literal, Self

from slam.errors import InputError
from slam.scenario.shipped import SHIPPED, find_scenario
from slam.scenario.source import ScenarioSource
from slam.sweep.job import format_setting


@dataclass(frozen=True, slots=True)
class SweepInput:
    """A scenario or a log, before mode, settings and seed."""

    kind: Literal["scenario", "log"]
    name: str
    source: str
    scenario: str
    """Source of its settings: the scenario itself; for a log ``replay``."""
    digest: str
    """Hash of the whole content; it changes the ids of the jobs."""
    slam: dict[str, Any]
    """Its own section ``slam``."""
    files: tuple[Path, ...] = ()
    """Its files, without those shipped with hopslam."""

    @classmethod
    def from_scenario(cls, name: str, beside: Path = Path()) -> Self:
        """Find a shipped scenario or a file, relative to ``beside``; ScenarioError if there is none."""
        path = find_scenario(name, beside)
        source = ScenarioSource(path)
        given = path.stem if path.parent == SHIPPED else str(path.resolve())
        files = tuple(path for path in source.paths if SHIPPED not in path.parents)
        return cls("scenario", str(source.data["name"]), given, given, _digest_of(source), _slam_of(source), files)

    @classmethod
    def from_log(cls, name: str, beside: Path = Path()) -> Self:
        """Read a recorded log; InputError if it cannot be read."""
        path, source = beside / name, ScenarioSource(find_scenario("replay"))
        try:
            with path.open("rb") as file:
                digest = file_digest(file, "sha256").hexdigest()
        except OSError as error:
            raise InputError(f"{path}: cannot be read: {error.strerror}; name a log or a scenario") from error
        whole = sha256((digest + _digest_of(source)).encode()).hexdigest()
        return cls("log", path.name.split(".")[0], str(path.resolve()), "replay", whole, _slam_of(source), (path,))

    @property
    def mode(self) -> str:
        """Mode in its own section ``slam``."""
        return str(self.slam.get("mode", "hopslam"))

    def mode_settings(self, mode: str) -> list[str]:
        """Return the settings that change it to this mode; empty if it has this mode."""
        if mode == self.mode:
            return []
        section = {"mode": mode} | (_paper_slam(self.kind) if mode == "paper" else {})
        if "odometry" in self.slam and mode != "dead_reckoning":
            section["odometry"] = self.slam["odometry"]
        return [format_setting("slam", section)]


def _slam_of(source: ScenarioSource) -> dict[str, Any]:
    slam = source.data.get("slam")
    return slam if isinstance(slam, dict) else {}


def _paper_slam(kind: str) -> dict[str, Any]:
    """Return section ``slam`` of the shipped scenario for paper mode, with values that the paper does not give."""
    return _slam_of(ScenarioSource(find_scenario("paper_corridor" if kind == "scenario" else "paper_replay")))


def _digest_of(source: ScenarioSource) -> str:
    """Hash of the scenario's data and of the map file that it names."""
    digest = sha256(json.dumps(source.data, sort_keys=True, default=str).encode())
    for file in source.map_files:
        digest.update(file.read_bytes())
    return digest.hexdigest()
