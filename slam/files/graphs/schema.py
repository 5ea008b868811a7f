"""``graph.json``, version 1: see docs/formats.md."""

from collections.abc import Iterator
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import ConfigDict, Field, model_validator

from slam.config import Section
from slam.graph.loop import Proposal
from slam.graph.run_graph import BELIEVED

VERSION = 1
PoseRow = tuple[float, float, float]
Matrix = tuple[PoseRow, PoseRow, PoseRow]
Number = Annotated[int, Field(ge=0, lt=2**31)]
ScanNumber = Annotated[int, Field(gt=-(2**31), lt=2**31)]
"""Below zero for a scan of an earlier run, which this one continues."""
Share = Annotated[float, Field(ge=0, le=1)]


class _Strict(Section):
    model_config = ConfigDict(strict=True)


class SavedKey(_Strict):
    """A key scan: the number of its scan in the run, its node, and the submaps that it was written into."""

    scan: ScanNumber
    node: Number
    submaps: Annotated[tuple[Number, ...], Field(min_length=1)]
    covariance: Matrix


class SavedSubmap(_Strict):
    """Consecutive key scans, by their indices in ``keys``.

    ``broken`` if only odometry joins it to the submap before.
    """

    number: Number
    node: Number
    T_local_submap: PoseRow
    broken: bool
    keys: tuple[Number, ...]


class SavedConstraint(_Strict):
    """Measured pose of one node as seen from another, and its weight."""

    first: Number
    second: Number
    T_first_second: PoseRow
    information: Matrix
    loop: Number | None
    """Number of the loop that the constraint belongs to."""
    weight: Share


class SavedLoop(_Strict):
    """A submap that was found in another one, with the result of the comparison: see slam/graph/loop.py."""

    number: Number
    submap: Number
    other: Number
    T_other_submap: PoseRow
    proposal: Proposal
    tested: Number
    """Number of key scans of the submap near the other one's path."""
    agreeing: Number
    """Number of those key scans that agree with the other submap."""
    share: Share
    """Mean agreement of the tested key scans, minus the penalty for beams through walls."""
    ambiguous: bool
    """True if a second pose was nearly as good, so that one direction is unconstrained."""
    scan: ScanNumber
    """Last scan of the submap."""
    weight: Share
    believed: bool
    """True if the graph accepts the loop, which it does for a weight above one half."""


class GraphDocument(_Strict):
    """The whole file."""

    format: Literal["hopslam graph"]
    version: Literal[1]
    frame: Literal["map"]
    T_base_laser: PoseRow
    nodes: tuple[PoseRow, ...]
    keys: tuple[SavedKey, ...]
    submaps: tuple[SavedSubmap, ...]
    constraints: tuple[SavedConstraint, ...]
    loops: tuple[SavedLoop, ...]

    @model_validator(mode="after")
    def _check_consistency(self) -> Self:
        if problem := next(self._problems(), None):
            raise ValueError(problem)
        return self

    def _problems(self) -> Iterator[str]:
        yield from self._key_problems()
        yield from self._submap_problems()
        yield from self._constraint_problems()
        yield from self._loop_problems()

    def _key_problems(self) -> Iterator[str]:
        if len({key.node for key in self.keys}) < len(self.keys):
            yield "keys: two have the same node"
        last, numbers = -(2**31), {submap.number for submap in self.submaps}
        for k, key in enumerate(self.keys):
            if key.node >= len(self.nodes):
                yield f"keys.{k}.node: {key.node} is not one of the {len(self.nodes)} nodes"
            if key.scan <= last:
                yield f"keys.{k}.scan: {key.scan} does not come after {last}"
            if not numbers.issuperset(key.submaps):
                yield f"keys.{k}.submaps: {key.submaps} do not all exist"
            if (problem := _not_a_covariance(key.covariance)) is not None:
                yield f"keys.{k}.covariance: {problem}"
            last = key.scan

    def _submap_problems(self) -> Iterator[str]:
        if len({submap.number for submap in self.submaps}) < len(self.submaps):
            yield "submaps: two have the same number"
        for k, submap in enumerate(self.submaps):
            if submap.node >= len(self.nodes):
                yield f"submaps.{k}.node: {submap.node} is not one of the {len(self.nodes)} nodes"
            for key in submap.keys:
                if key >= len(self.keys) or submap.number not in self.keys[key].submaps:
                    yield f"submaps.{k}.keys: {key} is not a key scan of this submap"

    def _constraint_problems(self) -> Iterator[str]:
        for k, edge in enumerate(self.constraints):
            if max(edge.first, edge.second) >= len(self.nodes) or edge.first == edge.second:
                yield f"constraints.{k}: connects {edge.first} to {edge.second}, of {len(self.nodes)} nodes"
            if edge.loop is not None and edge.loop >= len(self.loops):
                yield f"constraints.{k}.loop: {edge.loop} is not one of the {len(self.loops)} loops"
            if edge.loop is None and edge.weight != 1.0:
                yield f"constraints.{k}.weight: only a constraint of a loop can have a weight below 1"
            if (problem := _not_a_covariance(edge.information)) is not None:
                yield f"constraints.{k}.information: {problem}"

    def _loop_problems(self) -> Iterator[str]:
        numbers, nodes = {submap.number: submap for submap in self.submaps}, {key.node for key in self.keys}
        own: dict[int, list[int]] = {}
        for edge in self.constraints:
            if edge.loop is not None:
                own.setdefault(edge.loop, []).append(edge.second)
        for k, loop in enumerate(self.loops):
            if loop.number != k:
                yield f"loops.{k}.number: is {loop.number}, at index {k}"
            if loop.submap not in numbers or loop.other not in numbers or not numbers[loop.other].keys:
                yield f"loops.{k}: joins submaps {loop.submap} and {loop.other}, which do not both exist"
            if loop.agreeing > loop.tested:
                yield f"loops.{k}.agreeing: {loop.agreeing} of {loop.tested} that were tested"
            if loop.believed != (loop.weight > BELIEVED):
                yield f"loops.{k}.believed: is true for weights above {BELIEVED:g} only; the weight is {loop.weight:g}"
            if not own.get(k) or not nodes.issuperset(own[k]):
                yield f"loops.{k}: it has no constraint, or one without a key scan"


def _not_a_covariance(rows: Matrix) -> str | None:
    matrix = np.array(rows)
    scale = max(float(np.abs(matrix).max()), 1e-300)
    if np.abs(matrix - matrix.T).max() > 1e-6 * scale or np.linalg.eigvalsh(matrix).min() < -1e-4 * scale:
        return "not symmetric and positive semidefinite"
    return None
