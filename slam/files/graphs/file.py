"""A graph on the disk: ``graph.json``, with a line for each node, key scan, submap, constraint and loop.

Its numbers are plain text that is read back exactly.
"""

import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from slam.errors import InputError
from slam.files.atomic_files import write_atomic
from slam.files.graphs.schema import VERSION, GraphDocument
from slam.files.json_files import read_bounded
from slam.graph.loop import Loop
from slam.graph.pose_graph import NO_LOOP, Edge, Edges
from slam.graph.run_graph import RunGraph
from slam.graph.submap import Submap
from slam.scenario.validation_message import error_message


def write_graph(path: Path, graph: RunGraph) -> None:
    """Write the file at once or not at all."""
    parts = {
        "format": json.dumps("hopslam graph"),
        "version": str(VERSION),
        "frame": json.dumps("map"),
        "T_base_laser": json.dumps(graph.T_base_laser.tolist()),
        "nodes": _lines(graph.nodes.tolist()),
        "keys": _lines(_keys(graph)),
        "submaps": _lines(_submaps(graph)),
        "constraints": _lines(_constraints(graph)),
        "loops": _lines(_loops(graph)),
    }
    write_atomic(path, "{\n" + ",\n".join(f'"{key}": {text}' for key, text in parts.items()) + "\n}\n")


def read_graph(path: Path) -> RunGraph:
    """Read the graph; InputError names the file, the key and what is wrong."""
    document = _parse(path)
    keys, edges = document.keys, _edges(document)
    return RunGraph(
        np.array(document.T_base_laser),
        np.array(document.nodes, np.float64).reshape(-1, 3),
        np.array([key.node for key in keys], np.int64),
        np.array([key.scan for key in keys], np.int64),
        tuple(key.submaps for key in keys),
        np.array([key.covariance for key in keys], np.float64).reshape(-1, 3, 3),
        tuple(
            Submap(saved.number, saved.node, np.array(saved.T_local_submap), saved.broken, list(saved.keys))
            for saved in document.submaps
        ),
        Edges.of(edges),
        np.array([saved.weight for saved in document.constraints], np.float64),
        _loops_of(document, edges),
        np.array([saved.weight for saved in document.loops], np.float64),
    )


def _keys(graph: RunGraph) -> Iterator[dict[str, Any]]:
    rows = zip(graph.scans.tolist(), graph.key_nodes.tolist(), graph.key_submaps, graph.covariances, strict=True)
    for scan, node, submaps, covariance in rows:
        yield {"scan": scan, "node": node, "submaps": submaps, "covariance": covariance.tolist()}


def _submaps(graph: RunGraph) -> Iterator[dict[str, Any]]:
    for submap in graph.submaps:
        yield {
            "number": submap.number, "node": submap.node, "T_local_submap": submap.T_local_submap.tolist(),
            "broken": submap.broken, "keys": submap.keys,
        }  # fmt: skip


def _constraints(graph: RunGraph) -> Iterator[dict[str, Any]]:
    rows = zip(*(column.tolist() for column in graph.edges), graph.edge_weights.tolist(), strict=True)
    for first, second, measured, information, loop, weight in rows:
        yield {
            "first": first, "second": second, "T_first_second": measured, "information": information,
            "loop": None if loop == NO_LOOP else loop, "weight": weight,
        }  # fmt: skip


def _loops(graph: RunGraph) -> Iterator[dict[str, Any]]:
    for loop, weight, believed in zip(graph.loops, graph.weights.tolist(), graph.believed.tolist(), strict=True):
        yield {
            "number": loop.number, "submap": loop.submap, "other": loop.other,
            "T_other_submap": loop.T_other_submap.tolist(), "proposal": loop.proposal, "tested": loop.tested,
            "agreeing": loop.agreeing, "share": loop.share, "ambiguous": loop.ambiguous, "scan": loop.scan,
            "weight": weight, "believed": believed,
        }  # fmt: skip


def _lines(items: Iterable[Any]) -> str:
    """Format a list with a line for each item."""
    return "[\n" + ",\n".join(map(json.dumps, items)) + "\n]"


def _parse(path: Path) -> GraphDocument:
    try:
        return GraphDocument.model_validate_json(read_bounded(path))
    except ValidationError as errors:
        raise InputError(f"{path}: {_validation_message(errors)}") from errors
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be read: {error}; give the graph.json of a run folder") from error


def _validation_message(errors: ValidationError) -> str:
    """Return the first wrong key, but a wrong version before all others."""
    error = min(errors.errors(), key=lambda error: error["loc"] != ("version",))
    if error["loc"] == ("version",) and error["type"] != "missing":
        return f"version: this hopslam reads version {VERSION}, and not {error['input']!r}; optimize again, or update"
    location, reason = error_message(error, GraphDocument)
    key = f"{'.'.join(map(str, location))}: " if location else ""
    return f"{key}{reason}; make it again with hopslam optimize"


def _edges(document: GraphDocument) -> list[Edge]:
    return [
        Edge(
            saved.first, saved.second, np.array(saved.T_first_second), np.array(saved.information),
            NO_LOOP if saved.loop is None else saved.loop,
        )
        for saved in document.constraints
    ]  # fmt: skip


def _loops_of(document: GraphDocument, edges: list[Edge]) -> tuple[Loop, ...]:
    own: list[list[Edge]] = [[] for _ in document.loops]
    for edge in edges:
        if edge.loop != NO_LOOP:
            own[edge.loop].append(edge)
    return tuple(
        Loop(
            saved.number, saved.submap, saved.other, np.array(saved.T_other_submap), saved.proposal, saved.tested,
            saved.agreeing, saved.share, saved.ambiguous, tuple(own[saved.number]), saved.scan,
        )
        for saved in document.loops
    )  # fmt: skip
