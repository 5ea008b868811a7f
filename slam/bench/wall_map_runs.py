"""Runs in the simulator whose line map, and other line maps of the same poses, are scored against the true walls."""

from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from slam.bench.merged_lines import MergedLines
from slam.bench.split_and_merge import SplitAndMerge
from slam.console.terminal import Terminal
from slam.deskew import deskewed
from slam.mapping.line_map import LineMap
from slam.pose import Pose2D
from slam.run.estimator import finish
from slam.run.experiment_setup import scenario_experiment
from slam.run.loop import Ending, run_loop
from slam.run.scoring.seen_walls import SeenWalls
from slam.run.scoring.wall_score import WallScore, score_walls
from slam.run.step import Step
from slam.run.warm_up import warm_up
from slam.scenario.file import load_scenario

OURS: Final = "ours"
ALL_SEGMENTS: Final = "all segments"
SPLIT_AND_MERGE: Final = "split-and-merge"
LINE_MAPS: Final = (OURS, ALL_SEGMENTS, SPLIT_AND_MERGE)
"""Line maps: this method's own; every segment of every mapped scan, as the paper keeps them; segments by
split-and-merge, merged. All from the same scans and estimated poses."""


@dataclass
class _OtherMaps:
    """Watcher that makes the other line maps during the run."""

    T_base_laser: Pose2D
    all_segments: LineMap = field(default_factory=LineMap)
    merged: MergedLines = field(default_factory=MergedLines)
    split: SplitAndMerge = field(default_factory=SplitAndMerge)

    def on_step(self, step: Step) -> None:
        """Add the scan if it was mapped."""
        observation, estimate = step.observation, step.estimate
        if estimate.segments is None:
            return
        T_map_laser = estimate.T_map_base @ self.T_base_laser
        self.all_segments.add(estimate.segments, T_map_laser)
        scan = deskewed(observation.scan, observation.odometry.twist, self.T_base_laser)
        self.merged.add(self.split(scan), T_map_laser)


@dataclass(frozen=True, slots=True, eq=False)
class WallMapRun:
    """Result of a run."""

    ending: Ending
    scores: dict[str, WallScore]
    """Score of the map of each of the LINE_MAPS."""


def run_wall_map(name: str, seed: int, settings: Sequence[str], allow_modules: Sequence[str] = ()) -> WallMapRun:
    """Drive the scenario with this seed, as ``hopslam run`` does with these settings, and score its maps."""
    scenario = load_scenario(name, [*settings, f"seed={seed}"], allow_modules)
    warm_up(Terminal(quiet=True), scenario.slam)
    experiment = scenario_experiment(scenario)
    slam = experiment.slam
    seen, others = SeenWalls(experiment.outlines, slam.T_base_laser), _OtherMaps(slam.T_base_laser)
    with closing(experiment.env):
        experiment.env.prepare(scenario.seed)
        ending = run_loop(
            experiment.env, slam, experiment.pilot, [seen, others], scenario.seed, duration=experiment.duration
        )
    finish(slam)
    maps = (slam.lines.ends, others.all_segments.ends, others.merged.ends)
    scores = {way: score_walls(seen.walls, seen.seen, lines) for way, lines in zip(LINE_MAPS, maps, strict=True)}
    return WallMapRun(ending, scores)


def total_score(scores: Sequence[WallScore]) -> WallScore:
    """Add up the scores of many runs: sums of lengths, all errors, and the longest phantom."""
    mapped, right, seen, found = np.array([score[:4] for score in scores]).sum(axis=0)
    return WallScore(
        float(mapped),
        float(right),
        float(seen),
        float(found),
        np.concatenate([score.length_errors for score in scores]),
        np.concatenate([score.whole_lengths for score in scores]),
        np.concatenate([score.end_errors for score in scores]),
        sum(score.doubled for score in scores),
        sum(score.free_air for score in scores),
        max(score.phantom for score in scores),
    )
