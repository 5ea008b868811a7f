"""YAML read safely, with the line of every key, so that an error can say where it is."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from slam.errors import ScenarioError
from slam.scenario.yaml_fault import UNREADABLE, yaml_fault

Location = tuple[str | int, ...]


class YamlFile:
    """The content of a YAML file whose top is a mapping.

    Raises ScenarioError, naming file and line, when it cannot be read, is not YAML, or names a key twice.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        root, data = self._parse()
        if root is None or not isinstance(data, dict):
            raise ScenarioError(f"{self.path}: such a file is a mapping of keys to values; see scenarios/corridor.yaml")
        self._root = root
        self.data: dict[str, Any] = data

    def place(self, location: Location) -> str:
        """``file:line`` of the key or item at this path, or of the nearest thing around it that the file has."""
        return f"{self.path}:{self._lines(location)[-1] + 1}"

    def depth(self, location: Location) -> int:
        """How many steps of this path the file has."""
        return len(self._lines(location)) - 1

    def _lines(self, location: Location) -> list[int]:
        """The line, from 0, of the top, and of each step of the path as far as the file has it."""
        node, lines = self._root, [self._root.start_mark.line]
        for step in location:
            found = next((pair for pair in _children(node) if pair[0] == step), None)
            if found is None:
                break
            _, line, node = found
            lines.append(line)
        return lines

    def _parse(self) -> tuple[yaml.Node | None, Any]:
        """The tree of nodes, which know their lines, and the plain data."""
        try:
            text = self.path.read_text(encoding="utf-8")
            root, data = yaml.compose(text, Loader=yaml.SafeLoader), yaml.safe_load(text)
            self._refuse_doubles(root)
            return root, data
        except OSError as error:
            raise ScenarioError(f"{self.path}: cannot be read: {error.strerror}") from error
        except UNREADABLE as error:
            line, fault = yaml_fault(error)
            place = self.path if line is None else f"{self.path}:{line}"
            raise ScenarioError(f"{place}: not valid YAML: {fault}") from error

    def _refuse_doubles(self, node: yaml.Node | None) -> None:
        seen: set[str | int] = set()
        for key, line, child in _children(node):
            if key in seen:
                raise ScenarioError(f"{self.path}:{line + 1}: {key}: this key stands here for the second time")
            seen.add(key)
            self._refuse_doubles(child)


def _children(node: yaml.Node | None) -> list[tuple[str | int, int, yaml.Node]]:
    """(key or index, line from 0, value) of what is directly inside."""
    if isinstance(node, yaml.MappingNode):
        return [(str(key.value), key.start_mark.line, value) for key, value in node.value]
    if isinstance(node, yaml.SequenceNode):
        return [(index, item.start_mark.line, item) for index, item in enumerate(node.value)]
    return []
