"""Shows a finished run from its folder, without estimating anything again."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from slam.deskew import deskewed
from slam.files.atomic_files import atomic_file, require_writable
from slam.named_code import import_optional
from slam.pose import FloatArray, Pose2D
from slam.run.results.run_record import RunRecord
from slam.run.viewer.live_run import LOST, ODOMETRY_ONLY
from slam.run.viewer.loop_events import LoopsShown, closure_text, end_text
from slam.run.viewer.palette import NO_SEGMENT, Colour, wall_colours
from slam.run.viewer.scene import Event, Frame, Scene, planned_route, plots

if TYPE_CHECKING:  # it imports rerun
    from slam.run.viewer.broadcast import Broadcast

_NEAR: Final = 0.06
"""Distance within which a point is drawn in the colour of a segment, metres; the folder does not say which points made
it."""
Track = Callable[[Iterable[int], int], Iterable[int]]
"""Function that shows the progress over a number of parts."""


def recording_of(folder: Path, track: Track) -> Path:
    """Return ``run.rrd`` in the folder of a run, made if it is missing; InputError for another folder."""
    path = folder / "run.rrd"
    if not path.is_file():
        make_recording(RunRecord.open(folder), path, track)
    return path


def make_recording(record: RunRecord, path: Path, track: Track) -> None:
    """Write the run in a folder to an .rrd file; InputError if that fails."""
    from slam.run.viewer.broadcast import Broadcast

    with require_writable(path, "give --rerun FILE.rrd elsewhere"), atomic_file(path) as draft:
        draft.touch()
        with Broadcast([draft], [], scene_of(record), print) as broadcast:
            for _ in track(show_finished(record, broadcast), len(record.traces.stamps)):
                pass


def notebook_viewer(recording: Path, width: int, height: int) -> Any:
    """Show a recording in rerun's viewer, as a widget of a notebook; InputError if its package is not installed."""
    import_optional("rerun_notebook", "notebook")
    import rerun
    from rerun.notebook import Viewer

    stream = rerun.RecordingStream("hopslam")
    viewer = Viewer(width=width, height=height, recording=stream)
    stream.log_file_from_path(recording)
    return viewer


def scene_of(record: RunRecord) -> Scene:
    """Return the scene of the run in a folder."""
    around = np.concatenate([record.traces.estimate[:, :2], record.walls.reshape(-1, 2)])
    route = planned_route(record.config)
    curves = plots(battery=bool(np.isfinite(record.traces.volts).any()))
    return Scene(record.T_base_laser, outlines=tuple(record.outlines), route=route, around=around, plots=curves)


def show_finished(record: RunRecord, broadcast: Broadcast) -> Iterator[int]:
    """Send everything; yield the index of each scan that was sent. The map shown is the final one."""
    from slam.run.viewer.chunks import map_chunks

    saved = record.saved_map
    points = np.empty((0, 2)) if saved is None else saved.mapper.map.points
    broadcast.send(list(map_chunks(0, float(record.traces.stamps[0]), points, record.walls)))
    steps = record.traces.steps
    matched = np.maximum.accumulate(np.where(steps["mapped"] == 1, np.arange(len(steps)), 0))  # last matched scan
    states = [(LOST, steps["lost"] == 1), (ODOMETRY_ONLY, record.traces.odometry_only[matched])]
    jumps = _jumps(record)
    changes = [(texts, are, np.append(are[:1], are[1:] != are[:-1])) for texts, are in states]
    for frame in frames_of(record):
        k = frame.index
        events = [Event(k, frame.stamp, *texts[not are[k]]) for texts, are, changed in changes if changed[k]]
        if k in jumps:
            events.append(Event(k, frame.stamp, "INFO", jumps[k]))
            frame = replace(frame, jumped=True, loops=_loops_until(record, k))
        broadcast.show(frame, events)
        yield k
    _show_end(record, broadcast)


def _show_end(record: RunRecord, broadcast: Broadcast) -> None:
    """Send the final run with all its loops closed, and how it ended."""
    from slam.run.viewer.chunks import loop_chunks

    traces, graph = record.traces, record.graph
    scan, stamp = len(traces.stamps) - 1, float(traces.stamps[-1])
    if graph is not None and traces.closed is not None and graph.loops:
        scan, stamp = scan + 1, stamp + float(np.median(np.diff(traces.stamps)))
        broadcast.send(list(loop_chunks(scan, stamp, LoopsShown.of_graph(graph, traces.closed))))
        last = Pose2D.from_array(traces.estimate[-1]), Pose2D.from_array(traces.closed[-1])
        broadcast.add_event(Event(scan, stamp, "INFO", end_text(graph, *last)))
    if record.metrics is not None and "back_end_lost" in record.metrics:
        broadcast.add_event(Event(scan, stamp, "WARN", record.metrics["back_end_lost"]))
    ending = "cut off" if record.metrics is None else str(record.metrics["ending"])
    broadcast.add_event(Event(scan, stamp, "INFO", ending))


def _jumps(record: RunRecord) -> dict[int, str]:
    """Return texts on the closures that were applied during the run, by the indices of their scans."""
    traces, graph = record.traces, record.graph
    if traces.local is None:
        return {}
    texts, last = {}, -1  # ``last``: submap of the previous closure; loops of later ones are shown at the next closure
    for k in np.flatnonzero(traces.jumps).tolist():
        submap = int(traces.steps["closure"][k])
        loops = [] if graph is None else [loop for loop in graph.loops if last < loop.submap <= submap]
        last = submap
        estimate, local = (Pose2D.from_array(poses[k]) for poses in (traces.estimate, traces.local))
        T_map_local = Pose2D()
        if k:
            before = Pose2D.from_array(traces.local[k - 1]).inverse()
            T_map_local = Pose2D.from_array(traces.estimate[k - 1]) @ before
        texts[k] = closure_text(loops, T_map_local @ local, estimate)
    return texts


def _loops_until(record: RunRecord, scan: int) -> LoopsShown | None:
    """Return the loops found until then, at their final positions."""
    if record.graph is None or record.traces.closed is None:
        return None
    return LoopsShown.of_graph(record.graph, record.traces.closed, scan)


def frames_of(record: RunRecord) -> Iterator[Frame]:
    """Yield scan by scan what a live viewer would have shown."""
    traces, T_base_laser = record.traces, record.T_base_laser
    scans, ends = record.segments
    edges = np.searchsorted(scans, np.arange(len(traces.stamps) + 1))
    for index, seen in zip(range(len(traces.stamps)), record.observations(), strict=False):
        scan = deskewed(seen.scan, seen.odometry.twist, T_base_laser) if record.config.slam.deskew else seen.scan
        pose = Pose2D.from_array(traces.estimate[index])
        points = (pose @ T_base_laser).transform(scan.points())
        own = ends[edges[index] : edges[index + 1]]
        colours = _directions(own, (pose @ T_base_laser).translation)
        row = traces.steps[index]
        yield Frame(
            index,
            float(traces.stamps[index]),
            pose,
            Pose2D.from_array(traces.odometry[index]),
            None if traces.truth is None else Pose2D.from_array(traces.truth[index]),
            points,
            _nearest(points, own, colours),
            own,
            colours,
            _covariance(row),
            None,
            int(row["iterations"]),
            1e-3 * float(row["extraction_ms"]),
            1e-3 * float(row["slam_ms"]),
            (float(row["v"]), float(row["omega"])),
            float(traces.volts[index]),
        )


def _directions(ends: FloatArray, laser: FloatArray) -> Colour:
    """Return the colours of segments (M, 2, 2), (M,), by the normal that points away from the sensor."""
    along = ends[:, 1] - ends[:, 0]
    normals = np.column_stack([along[:, 1], -along[:, 0]])
    away = np.sign(np.sum(normals * (ends[:, 0] - laser), axis=1))
    return wall_colours(np.arctan2(away * normals[:, 1], away * normals[:, 0]))


def _nearest(points: FloatArray, ends: FloatArray, colours: Colour) -> Colour:
    """Return the colour of the segment next to each point (N,)."""
    own = np.full(len(points), NO_SEGMENT, np.uint32)
    if not len(ends):
        return own
    along = ends[:, 1] - ends[:, 0]
    offset = points[:, None] - ends[None, :, 0]
    share = np.clip(np.sum(offset * along, axis=2) / np.maximum(np.sum(along**2, axis=1), 1e-12), 0.0, 1.0)
    distance = np.linalg.norm(offset - share[..., None] * along, axis=2)
    near = distance.min(axis=1) < _NEAR
    own[near] = colours[distance.argmin(axis=1)[near]]
    return own


def _covariance(row: Any) -> FloatArray | None:
    """Return the covariance (3, 3) of a row of the table; None if it has none."""
    xx, xy, xt, yy, yt, tt = (float(row[f"cov_{name}"]) for name in ("xx", "xy", "xth", "yy", "yth", "thth"))
    return None if np.isnan(xx) else np.array([[xx, xy, xt], [xy, yy, yt], [xt, yt, tt]])
