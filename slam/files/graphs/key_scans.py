"""Key scans on the disk: ``key_scans.npz``, plain arrays, in the order of ``keys`` in ``graph.json``."""

from collections.abc import Iterable, Iterator
from dataclasses import astuple
from pathlib import Path
from typing import Any, Final
from zipfile import BadZipFile

import numpy as np

from slam.errors import InputError
from slam.files.atomic_files import atomic_file
from slam.graph.key_scan import KeyScan
from slam.graph.known_graph import KnownGraph
from slam.graph.run_graph import RunGraph
from slam.lidars import Lidar
from slam.pose import FloatArray

VERSION: Final = 1
_SHAPES: Final[dict[str, tuple[int, ...]]] = {
    "T_local_laser": (3,), "information": (3, 3), "share": (), "wheels": (3,), "lidar": (6,), "facets": (), "beams": (),
    "deskewed": (),
}  # fmt: skip
"""Arrays with a row for each key scan, and the shape of the row; ``facets`` and ``beams`` are counts."""
_ROWS: Final = "facet_rows", "ranges", "bearings"


def write_key_scans(path: Path, keys: Iterable[KeyScan]) -> None:
    """Write the file at once or not at all."""
    rows = list(keys)
    fans = [key.bearings for key in rows]
    arrays = {
        "version": np.array(VERSION),
        "T_local_laser": np.array([key.T_local_laser for key in rows]),
        "information": np.array([key.information for key in rows]),
        "share": np.array([key.agreeing_share for key in rows]),
        "wheels": np.array([key.wheel_motion for key in rows]),
        "lidar": np.array([astuple(key.lidar) for key in rows], np.float64),
        "facets": np.array([len(key.facets) for key in rows], np.int64),
        "beams": np.array([len(key.ranges) for key in rows], np.int64),
        "deskewed": np.array([fan is not None for fan in fans], np.bool_),
        "facet_rows": np.concatenate([key.facets for key in rows]),
        "ranges": np.concatenate([key.ranges for key in rows]),
        "bearings": np.concatenate([np.empty(0, np.float32), *(fan for fan in fans if fan is not None)]),
    }
    with atomic_file(path) as draft, draft.open("wb") as file:
        np.savez_compressed(file, **arrays)  # type: ignore[arg-type]


def read_known_graph(path: Path, graph: RunGraph) -> KnownGraph:
    """Read the key scans of this graph, and return the graph with them; InputError names the file and what is wrong."""
    arrays = _read(path)
    _require_whole(path, arrays, len(graph.scans))
    return KnownGraph.of(graph, tuple(_keys(arrays, graph)))


def _keys(arrays: dict[str, Any], graph: RunGraph) -> Iterator[KeyScan]:
    deskewed, beams = arrays["deskewed"], arrays["beams"]
    facets = _split(arrays["facet_rows"], arrays["facets"])
    ranges = _split(arrays["ranges"], beams)
    bearings = iter(_split(arrays["bearings"], beams[deskewed]))
    for k, submaps in enumerate(graph.key_submaps):
        angle_min, step, count, *rest = arrays["lidar"][k].tolist()
        yield KeyScan(
            arrays["T_local_laser"][k], submaps, facets[k], ranges[k], Lidar(angle_min, step, int(count), *rest),
            next(bearings) if deskewed[k] else None, arrays["information"][k], float(arrays["share"][k]),
            arrays["wheels"][k], int(graph.scans[k]),
        )  # fmt: skip


def _split(rows: Any, counts: Any) -> list[Any]:
    return np.split(rows, np.cumsum(counts)[:-1]) if len(counts) else []


def _read(path: Path) -> dict[str, Any]:
    try:
        with np.load(path, allow_pickle=False) as file:
            return {name: file[name] for name in ("version", *_SHAPES, *_ROWS)}
    except (OSError, ValueError, KeyError, EOFError, BadZipFile) as error:
        raise InputError(f"{path}: no key scans can be read: {error}; make it again with hopslam optimize") from error


def _require_whole(path: Path, arrays: dict[str, Any], count: int) -> None:
    if problem := next(_problems(arrays, count), None):
        raise InputError(f"{path}: {problem}; make it again with hopslam optimize")


def _problems(arrays: dict[str, Any], count: int) -> Iterator[str]:
    if arrays["version"].tolist() != VERSION:
        yield f"version: this hopslam reads version {VERSION}, and not {arrays['version']}"
    for name, shape in _SHAPES.items():
        if arrays[name].shape != (count, *shape):
            yield f"{name}: has shape {arrays[name].shape}, and not {(count, *shape)} as graph.json asks"
    for name in ("facets", "beams"):
        if arrays[name].dtype != np.int64 or (arrays[name] < 0).any():
            yield f"{name}: not whole numbers of 0 and more"
    if arrays["deskewed"].dtype != np.bool_:
        yield "deskewed: neither true nor false"
    totals = arrays["facets"].sum(), arrays["beams"].sum(), arrays["beams"][arrays["deskewed"]].sum()
    for name, total, columns in zip(_ROWS, totals, ((7,), (), ()), strict=True):
        if arrays[name].shape != (total, *columns):
            yield f"{name}: has shape {arrays[name].shape}, and not {(int(total), *columns)}"
    for name in ("T_local_laser", "information", "share", "wheels", "facet_rows", "bearings"):
        if not _is_finite(arrays[name]):
            yield f"{name}: has a number that is not finite"


def _is_finite(array: FloatArray) -> bool:
    return array.dtype.kind == "f" and bool(np.isfinite(array).all())
