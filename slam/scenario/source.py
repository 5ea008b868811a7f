"""The data of a scenario: a YAML file, the files that it extends, and settings that override them."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

from slam.errors import ScenarioError
from slam.scenario.random_value import is_random
from slam.scenario.settings import apply_settings, one_or_several, parse_setting
from slam.scenario.shipped import find_scenario
from slam.scenario.yaml_file import KeyPath, YamlFile

_MAP_FILE: Final[KeyPath] = ("world", "map", "file")


class ScenarioSource:
    """The data of a scenario, and for each key its place in the files.

    ``extends: NAME`` in a file merges that file's keys over those of another scenario, mapping by mapping; a list or a
    plain value replaces the other's as a whole.
    """

    def __init__(self, path: Path, settings: str | Sequence[str] = ()) -> None:
        self._files = _extended_files(path)
        overrides = [parse_setting(text) for text in one_or_several(settings)]
        self._by_hand = [key_path for key_path, _ in overrides]
        self.data: dict[str, Any] = {}
        for file in reversed(self._files):
            self.data = _merged(self.data, file.data)
        apply_settings(self.data, overrides)
        self.data.setdefault("name", path.stem)

    @property
    def folder(self) -> Path:
        """Folder of the YAML file that names the ROS map; the path of the map is relative to it."""
        return self._file_of(_MAP_FILE).path.parent

    @property
    def map_files(self) -> list[Path]:
        """Existing files among the ROS map of the scenario, if any, and its image."""
        world = self.data.get("world")
        named = world.get("map") if isinstance(world, dict) else None
        header = self.folder / str(named.get("file")) if isinstance(named, dict) else None
        if header is None or not header.is_file():
            return []
        image = header.parent / str(YamlFile(header).data.get("image"))
        return [header, image] if image.is_file() else [header]

    @property
    def paths(self) -> list[Path]:
        """All files of the scenario."""
        return [*(file.path for file in self._files), *self.map_files]

    def error(self, key_path: KeyPath, reason: str) -> ScenarioError:
        """Make the error that describes in one line the fault of the key at this path, and its place."""
        key = ".".join(map(str, key_path)) or "scenario"
        return ScenarioError(f"{self._place(key_path)}: {key}: {reason}")

    def _place(self, key_path: KeyPath) -> str:
        by_hand = any(path[: len(key_path)] == key_path[: len(path)] for path in self._by_hand)
        return "--set" if by_hand else self._file_of(key_path).place(key_path)

    def _file_of(self, key_path: KeyPath) -> YamlFile:
        """Find the first file that has this key, or the longest part of its path."""
        return max(self._files, key=lambda file: file.depth(key_path))


def _extended_files(path: Path) -> list[YamlFile]:
    """Read the file, the one that it extends, and so on."""
    files = [YamlFile(path)]
    while "extends" in files[-1].data:
        name = files[-1].data.pop("extends")
        try:
            base = find_scenario(str(name), files[-1].path.parent)
        except ScenarioError as error:
            raise ScenarioError(f"{files[-1].place(('extends',))}: extends: {error}") from error
        if any(file.path.samefile(base) for file in files):
            raise ScenarioError(f"{files[-1].place(('extends',))}: extends: {name} extends this file; break the ring")
        files.append(YamlFile(base))
        files[-1].data.pop("name", None)
    return files


def _merged(below: Any, above: Any) -> Any:
    if not (isinstance(below, dict) and isinstance(above, dict)) or is_random(below) or is_random(above):
        return above
    return below | {key: _merged(below.get(key), value) for key, value in above.items()}
