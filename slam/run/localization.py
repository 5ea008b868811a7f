"""Experiments in a map that was saved: localising in it, and mapping on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Literal

from slam.files.maps.file import read_map
from slam.line_localizer import LineLocalizer
from slam.localize_then_map import LocalizeThenMap
from slam.run.experiment import Experiment
from slam.run.pilot import ReplayPilot
from slam.run.results.localization_metrics import measure_localization
from slam.run.wanderer import FindThenDrive, Wanderer
from slam.saved_slam import relocate


def continued(experiment: Experiment, path: Path, start: Literal["given", "saved", "search"]) -> Experiment:
    """The experiment, which goes on mapping in the map of this file.

    The robot is where the experiment has it (``given``), where it was when the map was saved (``saved``), or must find
    its place first (``search``), for which a simulated robot wanders. InputError for a map that cannot be used.
    """
    config, mount = experiment.scenario.slam, experiment.slam.T_base_laser
    saved = read_map(path, config)
    experiment = replace(experiment, notes=experiment.notes | {"map": str(path), "start": start})
    if start == "search":
        continuation = LocalizeThenMap(config, mount, saved)
        return _searching(replace(experiment, slam=continuation), lambda: continuation.slam is not None)
    place = saved.T_map_base if start == "saved" else experiment.slam.T_map_base
    return replace(experiment, slam=relocate(config, mount, saved, place))


def localized(experiment: Experiment, path: Path) -> Experiment:
    """The experiment, which finds its place in the map of this file and leaves the map as it is.

    A simulated robot wanders until it is sure, and then drives its route, or wanders on where it has none. InputError
    for a map that cannot be used.
    """
    config = experiment.scenario.slam
    localizer = LineLocalizer(config, experiment.slam.T_base_laser, read_map(path, config).mapper.map)
    notes = experiment.notes | {"map": str(path)}
    localizing = replace(experiment, slam=localizer, notes=notes, measures=measure_localization)
    return _searching(localizing, lambda: localizer.sure)


def _searching(experiment: Experiment, known: Callable[[], bool]) -> Experiment:
    """A robot that can be driven wanders while its place is not known."""
    if isinstance(experiment.pilot, ReplayPilot):
        return experiment
    then = experiment.pilot if experiment.scenario.route.waypoints else Wanderer()
    start = experiment.scenario.robot.start.pose
    return replace(experiment, pilot=FindThenDrive(known, then), T_map_odom=start)
