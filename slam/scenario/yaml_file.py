"""Safe reading of YAML, with the line of every key for messages, and readable faults."""

import re
from functools import lru_cache
from pathlib import Path
from typing import Any, Final

import yaml
from yaml.constructor import SafeConstructor

from slam.errors import ScenarioError
from slam.limits import YAML_DEPTH, YAML_DIGITS, YAML_NODES, YAML_SIZE

KeyPath = tuple[str | int, ...]
"""Steps from the top of a scenario to a key: names of keys, and indices of list items."""
YAML_ERRORS: Final = (yaml.YAMLError, ValueError, KeyError, AttributeError, RecursionError)
"""Exceptions of PyYAML for invalid text; the builtin ones are raised for values such as 2024-13-45."""
_TEXT: Final = "tag:yaml.org,2002:str"
_WORDS: Final = (
    (r"'\\t' that cannot start", "a tab; YAML is indented with spaces only"),
    (r"character ('.+') that cannot start", "text that begins with {0} must be in quotes"),
    (r"but found '([\]}])'", "a {0} too many"),
    (r"expected <block end>, but found '<scalar>'", "text after the end of the value; use the other quotes"),
    (r"expected <block end>, but found '-'", "a list item among keys; put it under a key, and indent it"),
    (r"expected <block end>", "this line does not fit those above it; check its indentation and theirs"),
    (r"expected '<document start>'", "this line does not belong to the keys above it; check its indentation"),
    (r"mapping values are not", "a ':' where none can be; check the indentation, and that a space follows the ':' of "
     "the line above; text with a ': ' in it must be in quotes"),
    (r"mapping keys are not|sequence entries are not", "a list item must begin on a line of its own"),
    (r"could not find expected ':'", "a key without ':' and a space after it"),
    (r"expected ',' or '(.)'", "a bracket is not closed by {0}, or a comma is missing"),
    (r"expected the node content", "a value is missing, or a bracket is not closed"),
    (r"unexpected end of stream", "a quotation mark is not closed"),
    (r"another document|unexpected document separator", "a second document begins; a file holds one, without ---"),
    (r"unknown escape|escape sequence", "in double quotes a \\ begins an escape; put the text in single quotes"),
    (r"expected chomping", "after | or > the text begins on the next line"),
    (r"undefined alias", "nothing above is marked with & for this *; put text that begins with * in quotes"),
    (r"second occurrence", "this & name marks something above already; choose another"),
    (r"constructor for the tag '(?:tag:yaml.org,2002:)?(.*)'", "the tag {0} is not read; write a plain value"),
    (r"unhashable key", "a key must be plain text; put one that begins with a bracket in quotes"),
    (r"for merging", "after << a mapping belongs; put the key in quotes if it is text"),
)  # fmt: skip
_FOUND_AT_THE_END: Final = re.compile(r"expected ',' or|the node content|unexpected end|could not find expected")
"""Faults for which the line where the value begins is clearer than the line where PyYAML found them."""


class YamlExcess(ValueError):
    """The text exceeds a limit."""


def load_yaml(text: str) -> Any:
    """Return the plain data of a YAML text, within the limits; raises one of YAML_ERRORS."""
    return read_yaml(text)[1]


def read_yaml(text: str) -> tuple[yaml.Node | None, Any]:
    """Return the tree of nodes and the plain data of a YAML text, within the limits; raises one of YAML_ERRORS."""
    if excess := YAML_SIZE.excess(len(text)):
        raise YamlExcess(excess)
    root = _tree(text)
    return root, None if root is None else SafeConstructor().construct_document(root)


@lru_cache(maxsize=16)
def _tree(text: str) -> yaml.Node | None:
    """Return the tree of nodes of a text; parsing it takes most of the time, and a scenario is often read again."""
    loader = yaml.SafeLoader(text)
    try:
        root = loader.get_single_node()
    finally:
        loader.dispose()
    if root is not None and (excess := YAML_NODES.excess(_count_nodes(root, {}, 1))):
        raise YamlExcess(excess)
    return root


def _count_nodes(node: yaml.Node, known: dict[int, int], depth: int) -> int:
    """Return the number of nodes below and including this one, each alias counted with its contents."""
    if id(node) in known:
        return known[id(node)]
    if excess := YAML_DEPTH.excess(depth):
        raise YamlExcess(excess)
    if isinstance(node, yaml.ScalarNode):
        if node.tag != _TEXT and (excess := YAML_DIGITS.excess(len(node.value))):
            raise YamlExcess(excess)
        return 1
    known[id(node)] = YAML_NODES.most + 1  # a node that contains itself has no end
    parts = [part for pair in node.value for part in (pair if isinstance(pair, tuple) else (pair,))]
    known[id(node)] = 1 + sum(_count_nodes(part, known, depth + 1) for part in parts)
    return known[id(node)]


class YamlFile:
    """Content of a YAML file whose top is a mapping.

    Raises ScenarioError, with file and line, if it cannot be read, is not YAML, or has a key twice.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        root, data = self._parse()
        if root is None or not isinstance(data, dict):
            raise ScenarioError(f"{self.path}: such a file is a mapping of keys to values; see scenarios/corridor.yaml")
        self._root = root
        self.data: dict[str, Any] = data

    def place(self, key_path: KeyPath) -> str:
        """Return ``file:line`` of the key or item at this path, or of the nearest parent in the file."""
        return f"{self.path}:{self._lines(key_path)[-1] + 1}"

    def depth(self, key_path: KeyPath) -> int:
        """Count the steps of this path that are in the file."""
        return len(self._lines(key_path)) - 1

    def _lines(self, key_path: KeyPath) -> list[int]:
        """Return the line, from 0, of the top, and of each step of the path that is in the file."""
        node, lines = self._root, [self._root.start_mark.line]
        for step in key_path:
            found = next((pair for pair in _children(node) if pair[0] == step), None)
            if found is None:
                break
            _, line, node = found
            lines.append(line)
        return lines

    def _parse(self) -> tuple[yaml.Node | None, Any]:
        """Read the tree of nodes, which know their lines, and the plain data."""
        try:
            if excess := YAML_SIZE.excess(self.path.stat().st_size):
                raise YamlExcess(excess)
            root, data = read_yaml(self.path.read_text(encoding="utf-8"))
            self._refuse_doubles(root)
            return root, data
        except OSError as error:
            raise ScenarioError(f"{self.path}: cannot be read: {error.strerror}") from error
        except YamlExcess as excess:
            raise ScenarioError(f"{self.path}: {excess}") from None
        except YAML_ERRORS as error:
            line, fault = explain_yaml_error(error)
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
    """Return (key or index, line from 0, value) of the direct children."""
    if isinstance(node, yaml.MappingNode):
        return [(str(key.value), key.start_mark.line, value) for key, value in node.value]
    if isinstance(node, yaml.SequenceNode):
        return [(index, item.start_mark.line, item) for index, item in enumerate(node.value)]
    return []


def explain_yaml_error(error: Exception) -> tuple[int | None, str]:
    """Return the line, from 1, of an error in YAML_ERRORS, if known, and its description."""
    if isinstance(error, yaml.MarkedYAMLError):
        problem = error.problem or error.context or "not YAML"
        began = error.context_mark if _FOUND_AT_THE_END.search(problem) else None
        mark = began or error.problem_mark
        return mark.line + 1 if mark else None, _in_plain_words(problem)
    if isinstance(error, yaml.YAMLError | UnicodeError):
        return None, f"not a text file: {str(error).splitlines()[0]}"
    if isinstance(error, YamlExcess):
        return None, str(error)
    if isinstance(error, RecursionError):
        return None, f"lists or mappings inside each other, over the limit of {YAML_DEPTH.most} levels"
    return None, f"a value cannot be read: {error}; put it in quotes if it is text"


def _in_plain_words(problem: str) -> str:
    for pattern, words in _WORDS:
        if (found := re.search(pattern, problem)) is not None:
            return words.format(*found.groups())
    return problem
