"""Modules that were moved, still found under their old names, with a warning that says the new one."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Sequence
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Final

MOVED: Final = {
    "sim.bench.long_life": "sim.bench.memory",
    "sim.bench.scene": "sim.bench.speed",
    "hardware.arcos.identity": "hardware.arcos.model",
    "hardware.arcos.units": "hardware.arcos.model",
    "hardware.arcos.wrapping": "hardware.base_odometry",
    "hardware.emulator.device": "hardware.emulator.connected_device",
    "hardware.emulator.ramp": "hardware.emulator.motor_controller",
    "hardware.opened_p3dx": "hardware.p3dx_setup",
    "hardware.scip.values": "hardware.scip.encoding",
    "hardware.sensor_clock": "hardware.scip.time_stamp",
    "hardware.wheel_scales": "hardware.base_odometry",
    "sim.casters": "sim.ray_casters",
    "sim.friction_arm": "sim.furniture",
    "sim.ids": "slam.env.ids",
    "sim.lent": "sim.mesh",
    "sim.movable": "sim.furniture",
    "sim.ramp": "sim.firmware",
    "sim.range_noise": "sim.lidar_noise",
    "sim.resources": "sim.p3dx",
    "sim.stall_guard": "sim.firmware",
    "sim.traction": "sim.wheels",
    "slam.config.own": "slam.config.section",
    "slam.config.whole": "slam.config.slam_config",
    "slam.late": "slam.named_code",
    "slam.line_continuation": "slam.localize_then_map",
    "slam.own_code": "slam.named_code",
    "slam.lines.own_extractor": "slam.lines.extraction",
    "slam.mapping.drift": "slam.mapping.map_uncertainty",
    "slam.matching.compass": "slam.matching.wall_heading",
    "slam.matching.hypothesis": "slam.matching.pose_hypothesis",
    "slam.matching.main_heading": "slam.matching.wall_heading",
    "slam.matching.own_map": "slam.matching.own_mapper",
    "slam.matching.surfel_memory": "slam.matching.surfel_mapper_state",
    "slam.own_array": "slam.own_checks",
    "slam.run.bench": "slam.bench",
    "slam.run.bench.paper.speed_up": "slam.bench.paper.table_2",
    "slam.run.bench.crispness": "slam.bench.map_shape",
    "slam.run.bench.hough_peer": "slam.bench.probabilistic_hough",
    "slam.run.bench.localize_trials": "slam.bench.localize_report",
    "slam.run.bench.methods": "slam.bench.line_extractors",
    "slam.run.bench.ransac_peer": "slam.bench.ransac",
    "slam.run.bench.slam_runs": "slam.bench.log_runs",
    "slam.run.calibration.file": "slam.run.calibration.report",
    "slam.run.calibration.picture": "slam.run.calibration.report",
    "slam.run.cli": "slam.cli.main",
    "slam.run.commands": "slam.cli",
    "slam.run.course": "slam.run.pilots",
    "slam.run.ending_signals": "slam.console.signals",
    "slam.run.dead_reckoning": "slam.run.estimator",
    "slam.run.env": "slam.env",
    "slam.run.interruption": "slam.run.watchers",
    "slam.run.lasting_output": "slam.console.robust_output",
    "slam.run.env.actions": "slam.run.arrays",
    "slam.run.env.catalogue": "slam.env.ids",
    "slam.run.env.driven_robot": "slam.env.robot_session",
    "slam.run.env.ends": "slam.env.step_state",
    "slam.run.env.info": "slam.env.episode",
    "slam.run.env.manual": "slam.env.ids",
    "slam.run.env.moment": "slam.env.step_state",
    "slam.run.env.ray_marching": "slam.env.occupancy_grid",
    "slam.run.env.rewards.coverage": "slam.env.rewards",
    "slam.run.env.rewards.no_reward": "slam.env.rewards",
    "slam.run.env.rewards.progress": "slam.env.rewards",
    "slam.run.env.seen_grid": "slam.env.occupancy_grid",
    "slam.run.env.views.goal": "slam.env.views",
    "slam.run.env.views.map": "slam.env.views",
    "slam.run.env.views.odometry": "slam.env.views",
    "slam.run.env.views.scan": "slam.env.views",
    "slam.run.env.views.slam_pose": "slam.env.views",
    "slam.run.env.window": "slam.env.rerun_window",
    "slam.run.env.worlds": "slam.env.episode_scenarios",
    "slam.run.logs": "slam.files.logs",
    "slam.run.logs.carmen_params": "slam.files.logs.carmen_message",
    "slam.run.logs.fields": "slam.files.fields",
    "slam.run.logs.frame_tree": "slam.files.logs.bag_poses",
    "slam.run.logs.laser_scan": "slam.files.logs.bag_contents",
    "slam.run.logs.replay": "slam.run.replay_robot",
    "slam.run.logs.tally": "slam.files.logs.read_statistics",
    "slam.run.logs.text": "slam.files.text_lines",
    "slam.run.logs.tracks": "slam.files.logs.bag_poses",
    "slam.run.logs.tum": "slam.files.tum",
    "slam.run.maps": "slam.files.maps",
    "slam.run.patience": "slam.run.loop",
    "slam.run.pilot": "slam.run.pilots",
    "slam.run.report.metric_rows": "slam.run.report.page",
    "slam.run.report.paper_curves": "slam.run.pictures.error_curves",
    "slam.run.results.error_picture": "slam.run.pictures.error_curves",
    "slam.run.results.figure_file": "slam.run.pictures.figure_style",
    "slam.run.results.files": "slam.files.atomic_files",
    "slam.run.results.localization_metrics": "slam.run.results.metrics",
    "slam.run.results.log_reader": "slam.run.results.run_log",
    "slam.run.results.map_picture": "slam.run.pictures.map_picture",
    "slam.run.results.palette": "slam.run.pictures.figure_style",
    "slam.run.results.plan": "slam.run.pictures.map_picture",
    "slam.run.results.progress": "slam.run.watchers",
    "slam.run.results.scan_picture": "slam.run.pictures.scan_picture",
    "slam.run.results.segment_files": "slam.run.log_lines",
    "slam.run.results.summary": "slam.run.run_and_report",
    "slam.run.results.world_picture": "slam.run.pictures.world_picture",
    "slam.run.ros": "slam.files.ros",
    "slam.run.ros.mcap_messages": "slam.files.ros.mcap_files",
    "slam.run.ros.mcap_writer": "slam.files.ros.mcap_files",
    "slam.run.ros.raw_message": "slam.files.ros.messages",
    "slam.run.ros.topics": "slam.files.ros.messages",
    "slam.run.ros.typestores": "slam.files.ros.messages",
    "slam.run.scenario": "slam.scenario",
    "slam.run.scoring.poses_at": "slam.run.scoring.pose_errors",
    "slam.run.suspensions": "slam.console.signals",
    "slam.run.scenario.cautions": "slam.scenario.checks",
    "slam.run.scenario.clearance": "slam.scenario.solids",
    "slam.run.scenario.complaint": "slam.scenario.validation_message",
    "slam.run.scenario.expected": "slam.scenario.expected_value",
    "slam.run.scenario.generators.build": "slam.scenario.template",
    "slam.run.scenario.generators.kinds": "slam.scenario.schema",
    "slam.run.scenario.generators.side": "slam.scenario.generators.passage",
    "slam.run.scenario.generators.site": "slam.scenario.world_plan",
    "slam.run.scenario.overview": "slam.scenario.file",
    "slam.run.scenario.people": "slam.scenario.world_plan",
    "slam.run.scenario.prism": "slam.scenario.solids",
    "slam.run.scenario.quantity": "slam.scenario.values",
    "slam.run.scenario.texts": "slam.scenario.settings",
    "slam.run.scenario.yaml_fault": "slam.scenario.yaml_file",
    "slam.run.sweep": "slam.sweep",
    "slam.run.sweep.driver": "slam.sweep.scheduler",
    "slam.run.sweep.options": "slam.sweep.make_plan",
    "slam.run.sweep.pool": "slam.sweep.process_pool",
    "slam.run.sweep.row": "slam.sweep.result_rows",
    "slam.run.sweep.shipment": "slam.sweep.code_bundle",
    "slam.run.sweep.store": "slam.sweep.result_store",
    "slam.run.sweep.subject": "slam.sweep.sweep_input",
    "slam.run.sweep.table": "slam.sweep.result_rows",
    "slam.run.sweep.versions": "slam.sweep.code_bundle",
    "slam.run.terminal": "slam.console.terminal",
    "slam.run.terminal_table": "slam.console.terminal_table",
    "slam.run.viewer.curves": "slam.run.viewer.scene",
    "slam.run.viewer.events": "slam.run.viewer.scene",
    "slam.run.viewer.finished": "slam.run.viewer.finished_run",
    "slam.run.viewer.frame": "slam.run.viewer.scene",
    "slam.run.viewer.recording": "slam.run.viewer.finished_run",
    "slam.run.viewer.run_viewer": "slam.run.viewer.live_run",
    "slam.run.viewer.setting": "slam.run.viewer.scene",
    "slam.run.wanderer": "slam.run.pilots",
}
"""Modules and packages of version 0.1 by their old names; the longest name that fits counts."""
_LONGEST_FIRST: Final = sorted(MOVED, key=len, reverse=True)
_PACKAGES: Final = ("slam.", "sim.", "hardware.")


class _Copy(Loader):
    """Fills a module of an old name with what the module of the new name holds."""

    def __init__(self, new: str) -> None:
        self._new = new

    def exec_module(self, module: ModuleType) -> None:
        own = {"__name__", "__spec__", "__loader__", "__package__"}
        module.__dict__.update({k: v for k, v in vars(import_module(self._new)).items() if k not in own})


class OldNames(MetaPathFinder):
    """Finds a moved module, and warns with FutureWarning."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """The module of this old name; None where the name is not old."""
        if not fullname.startswith(_PACKAGES):
            return None
        old = next((name for name in _LONGEST_FIRST if f"{fullname}.".startswith(f"{name}.")), None)
        if old is None:
            return None
        new = MOVED[old] + fullname.removeprefix(old)
        warnings.warn(f"{fullname} is an old name: the module is {new} now", FutureWarning, stacklevel=2)
        return ModuleSpec(fullname, _Copy(new), is_package=True)


def find_old_names() -> None:
    """Let Python find moved modules under their old names, before it looks into folders that a move left behind."""
    if not any(isinstance(finder, OldNames) for finder in sys.meta_path):
        sys.meta_path.insert(0, OldNames())
