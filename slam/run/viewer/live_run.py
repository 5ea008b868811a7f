"""Shows a run in progress: turns steps into frames and events."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import nan
from typing import TYPE_CHECKING, Final

import numpy as np

from slam.deskew import deskewed
from slam.graph.run_graph import RunGraph
from slam.lines.segments import Segments
from slam.mapping.surfel_map import SurfelMap
from slam.pose import FloatArray, Pose2D
from slam.run.step import Step
from slam.run.viewer.loop_events import LoopsShown, closure_text, end_text
from slam.run.viewer.palette import NO_SEGMENT, Colour, wall_colours
from slam.run.viewer.scene import Event, Frame, Level, Scene
from slam.sonar_ring import echo_points

if TYPE_CHECKING:  # it imports rerun
    from slam.run.viewer.broadcast import Broadcast

EventText = tuple[Level, str]
LOST: Final[tuple[EventText, EventText]] = (
    ("WARN", "lost: the scans do not fit the map"),
    ("INFO", "sure of its pose again"),
)
"""Texts for the begin and the end of a state."""
ODOMETRY_ONLY: Final[tuple[EventText, EventText]] = (
    ("WARN", "odometry alone: the scan was rejected"),
    ("INFO", "the scans fit the map again"),
)
_NO_ENDS: Final = np.empty((0, 2, 2))


class RunViewer:
    """Turns steps into frames and events."""

    def __init__(self, broadcast: Broadcast, scene: Scene) -> None:
        self._broadcast, self._scene, self._detector = broadcast, scene, EventDetector()
        self._scan, self._stamp, self._period, self._T_map_base = 0, 0.0, 0.0, Pose2D()

    def on_step(self, step: Step) -> None:
        """Show one step."""
        scene = self._scene
        self._scan, self._stamp = step.index, step.estimate.stamp
        self._period, self._T_map_base = step.observation.scan.scan_time, step.estimate.T_map_base
        frame = frame_of(step, scene.T_map_odom, scene.T_base_laser, scene.deskew)
        if (closure := step.estimate.closure) is not None:
            shown = LoopsShown.of_closure(closure, scene.T_base_laser.inverse())
            frame = replace(frame, loops=shown, jumped=True)
        self._broadcast.show(frame, list(self._detector.detect(step)))

    def show_closed(self, graph: RunGraph, poses: FloatArray, surfel_map: SurfelMap) -> None:
        """Show the final run, ``T_map_base`` (S, 3) of all scans, just after the last one."""
        from slam.run.viewer.chunks import loop_chunks, map_chunks

        if not graph.loops:
            return
        self._scan, self._stamp = self._scan + 1, self._stamp + self._period
        self._broadcast.send(list(loop_chunks(self._scan, self._stamp, LoopsShown.of_graph(graph, poses))))
        self._broadcast.send(list(map_chunks(self._scan, self._stamp, surfel_map.points, surfel_map.ends)))
        text = end_text(graph, self._T_map_base, Pose2D.from_array(poses[-1]))
        self._broadcast.add_event(Event(self._scan, self._stamp, "INFO", text))

    def warn(self, text: str) -> None:
        """Show a warning at the last scan."""
        self._broadcast.add_event(Event(self._scan, self._stamp, "WARN", text))

    def end(self, ending: str, error: Exception | None = None) -> None:
        """Show how the run ended."""
        text = ending if error is None else f"{ending}: {error}"
        self._broadcast.add_event(Event(self._scan, self._stamp, "INFO" if error is None else "ERROR", text))


class EventDetector:
    """Turns steps into events, one at the begin of each state.

    Lost, odometry alone and stalled also have one at the end.
    """

    def __init__(self) -> None:
        self._on: dict[str, bool] = {}
        self._T_map_local = Pose2D()

    def detect(self, step: Step) -> Iterator[Event]:
        """Yield the events that begin or end in this step."""
        for level, text in self._new_events(step):
            yield Event(step.index, step.estimate.stamp, level, text)

    def _new_events(self, step: Step) -> Iterator[EventText]:
        seen, match = step.observation, step.estimate.match
        if step.index == 0:
            yield "INFO", f"first scan: {len(seen.scan.ranges)} beams to {seen.scan.range_max:g} m"
        if step.timeouts:
            yield "WARN", f"the robot was silent: {step.timeouts} timeout{'s' * (step.timeouts > 1)} before this scan"
        if (lost := self._changed("lost", step.estimate.lost)) is not None:
            yield LOST[not lost]
        if step.estimate.mapped and (alone := self._changed("odometry only", match.odometry_only)) is not None:
            yield ODOMETRY_ONLY[not alone]
        if self._changed("searched", match.searched):
            yield "INFO", f"odometry in doubt: searched around it, {match.inliers:.0f} of {match.points} pieces agree"
        if (closure := step.estimate.closure) is not None:
            before = self._T_map_local @ step.estimate.T_local_base
            yield "INFO", closure_text(closure.loops, before, step.estimate.T_map_base)
        if self._changed("back end lost", bool(step.estimate.back_end_lost)):
            yield "WARN", step.estimate.back_end_lost
        self._T_map_local = step.estimate.T_map_local
        if (stalled := self._changed("stalled", seen.stalled)) is not None:
            yield ("WARN", "stalled: a wheel cannot turn") if stalled else ("INFO", "the wheels turn again")
        if seen.battery is not None and self._changed("battery low", seen.battery.level != "good"):
            yield "WARN", f"the battery is low: {seen.battery.volts:.1f} V"
        if self._changed("faulty", bool(seen.fault_flags)):
            yield "WARN", f"the base reports faults, flags {seen.fault_flags:#06x}"
        if self._changed("bumped", any(seen.bumpers)):
            yield "WARN", "a bumper is pressed"
        if self._changed("collided", seen.collided):
            yield "ERROR", "collided"

    def _changed(self, name: str, now: bool) -> bool | None:
        """Return the new state, None if it is unchanged."""
        before, self._on[name] = self._on.get(name, False), now
        return now if now != before else None


def frame_of(step: Step, T_map_odom: Pose2D, T_base_laser: Pose2D, deskew: bool) -> Frame:
    """Make the frame of a step; the scan is deskewed as in the method."""
    estimate, seen = step.estimate, step.observation
    scan, odometry = seen.scan, seen.odometry
    if deskew:
        scan = deskewed(scan, odometry.twist, T_base_laser)
    T_map_laser = estimate.T_map_base @ T_base_laser
    points = scan.points()
    colours, ends, end_colours = coloured(points, estimate.segments, T_map_laser)
    return Frame(
        step.index,
        estimate.stamp,
        estimate.T_map_base,
        T_map_odom @ odometry.T_odom_base,
        seen.T_map_base,
        T_map_laser.transform(points),
        colours,
        ends,
        end_colours,
        estimate.covariance,
        estimate.unconstrained,
        estimate.match.iterations,
        estimate.extraction_time,
        estimate.total_time,
        (step.applied.linear, step.applied.angular),
        nan if seen.battery is None else seen.battery.volts,
        estimate.T_map_base.transform(echo_points(seen.sonar)) if seen.sonar else None,
    )


def coloured(points: FloatArray, segments: Segments | None, T_map_laser: Pose2D) -> tuple[Colour, FloatArray, Colour]:
    """Return the colours of the points (N,), the segments of a scan, map frame, (M, 2, 2), and their colours."""
    colours = np.full(len(points), NO_SEGMENT, np.uint32)
    if segments is None:
        return colours, _NO_ENDS, colours[:0]
    own = wall_colours(segments.theta + T_map_laser.theta)
    for first, last, colour in zip(segments.first.tolist(), segments.last.tolist(), own.tolist(), strict=True):
        colours[first : last + 1] = colour
    ends = T_map_laser.transform(np.stack([segments.start, segments.end], axis=1).reshape(-1, 2))
    return colours, ends.reshape(-1, 2, 2), own
