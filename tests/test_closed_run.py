"""Runs that end with closed loops: their files, read back, and their metrics."""

import json
import shutil
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from slam.cli.main import app
from slam.errors import InputError
from slam.files.graphs.file import read_graph, write_graph
from slam.files.tum import format_tum, read_tum
from slam.mapping.surfel_map import SurfelMap
from slam.odometry import Twist2D
from slam.pose import Pose2D, relative_poses
from slam.run.experiment_setup import continue_mapping, replay_experiment
from slam.run.report.faults import faults
from slam.run.results.metrics import measure
from slam.run.results.run_record import RunRecord
from slam.scenario.file import load_scenario


@pytest.fixture
def copy(lap_run: Path, tmp_path: Path) -> Path:
    return shutil.copytree(lap_run, tmp_path / "run")


def test_the_closed_trajectory_has_every_scan(lap_run: Path) -> None:
    stamps, estimate = read_tum(lap_run / "trajectory.tum")
    closed_stamps, closed = read_tum(lap_run / "closed.tum")
    np.testing.assert_array_equal(closed_stamps, stamps)
    assert 0.01 < np.hypot(*(closed - estimate)[:, :2].T).max() < 0.5


def test_key_scans_lie_where_the_graph_has_them(lap_run: Path) -> None:
    graph, record = read_graph(lap_run / "graph.json"), RunRecord.open(lap_run)
    assert record.traces.closed is not None
    bases = record.traces.closed[graph.scans]
    lasers = np.array([(Pose2D.from_array(pose) @ record.T_base_laser).as_array() for pose in bases])
    np.testing.assert_allclose(lasers, graph.poses, atol=3e-6)


def test_the_closed_trajectory_is_closer_to_the_truth(copy: Path, lap_path: list[Pose2D]) -> None:
    stamps, _ = read_tum(copy / "trajectory.tum")
    rows = zip(stamps.tolist(), lap_path, strict=True)
    (copy / "groundtruth.tum").write_text("".join(format_tum(stamp, pose) + "\n" for stamp, pose in rows))
    metrics = measure(copy)
    assert metrics["closed_ate_rmse_m"] < metrics["ate_rmse_m"] < metrics["odometry_ate_rmse_m"]
    assert metrics["closed_ate_rmse_m"] < 0.1
    assert metrics["closures"] > 0


def test_the_front_end_never_jumps(lap_run: Path, lap_path: list[Pose2D]) -> None:
    traces = RunRecord.open(lap_run).traces
    assert traces.local is not None
    motions = relative_poses(traces.local[:-1], traces.local[1:])
    true = np.array([a.between(b).as_array() for a, b in pairwise(lap_path)])
    assert np.abs(motions - true).max() < 0.1
    closures = traces.steps["closure"]
    assert ((closures == -1) | (closures >= 0)).all()
    first = int(np.argmax(closures >= 0))
    np.testing.assert_allclose(traces.local[0], traces.estimate[0], atol=2e-6)
    np.testing.assert_allclose(traces.local[:first], traces.estimate[:first], atol=0.1)  # the map limits the drift


def test_a_graph_is_read_back_bit_for_bit(lap_run: Path, tmp_path: Path) -> None:
    path = lap_run / "graph.json"
    graph = read_graph(path)
    write_graph(tmp_path / "again.json", graph)
    assert (tmp_path / "again.json").read_bytes() == path.read_bytes()
    assert graph.believed.all()
    assert all(edge.loop == loop.number for loop in graph.loops for edge in loop.edges)


def test_the_same_log_gives_the_same_graph(lap_log: Path, lap_run: Path, tmp_path: Path) -> None:
    folder = replay_experiment(lap_log, load_scenario("replay")).run(tmp_path / "again", pictures=False).folder
    for name in ("closed.tum", "graph.json", "map.json"):
        assert (folder / name).read_bytes() == (lap_run / name).read_bytes()


def test_without_loops_no_trajectory_is_closed(lap_log: Path, tmp_path: Path) -> None:
    experiment = replay_experiment(lap_log, load_scenario("replay", ["slam.loops=never"]))
    folder = experiment.run(tmp_path / "run", pictures=False).folder
    assert not (folder / "closed.tum").exists()
    assert not (folder / "graph.json").exists()
    record = RunRecord.open(folder)
    assert record.traces.closed is None
    assert record.traces.final is record.traces.estimate
    assert record.saved_map is not None


def test_a_killed_run_has_no_closed_trajectory(copy: Path) -> None:
    for name in ("closed.tum", "graph.json", "map.json", "metrics.json"):
        (copy / name).unlink()
    record = RunRecord.open(copy)
    assert record.traces.closed is None
    assert record.graph is None


def test_steps_of_an_older_version_are_read(copy: Path) -> None:
    lines = (copy / "steps.csv").read_text().splitlines()
    older = lines[0].split(",").index("local_x")
    (copy / "steps.csv").write_text("\n".join(",".join(line.split(",")[:older]) for line in lines) + "\n")
    record = RunRecord.open(copy)
    assert record.traces.local is None
    assert "closures" not in measure(copy)


def test_a_closed_trajectory_of_another_run_is_refused(copy: Path) -> None:
    lines = (copy / "closed.tum").read_text().splitlines()
    (copy / "closed.tum").write_text("\n".join(lines[:-3]) + "\n")
    with pytest.raises(InputError, match=r"closed.tum: has \d+ poses for \d+ scans"):
        RunRecord.open(copy)


def test_an_interrupted_run_is_closed(lap_log: Path, tmp_path: Path) -> None:
    experiment = replay_experiment(lap_log, load_scenario("replay"))

    class Impatient:
        progress = 0.0

        def __init__(self) -> None:
            self.left = 200

        def command(self, *_: object) -> Twist2D:
            self.left -= 1
            if not self.left:
                raise KeyboardInterrupt
            return Twist2D()

    outcome = replace(experiment, pilot=Impatient()).run(tmp_path / "run", pictures=False)
    assert outcome.ending == "interrupted"
    assert RunRecord.open(outcome.folder).traces.closed is not None


@pytest.mark.parametrize(
    ("key", "value", "complaint"),
    [
        ("version", 2, "version: this hopslam reads version 1, and not 2"),
        ("format", "hopslam map", "format: "),
        ("nodes.0.0", float("nan"), "nodes.0.0: "),
        ("nodes.0.0", "1", "nodes.0.0: expected a number"),
        ("nodes.0", [1.0, 2.0], "nodes.0"),
        ("nodes", [[0.0, 0.0, 0.0]], r"keys.\d.node: \d is not one of the 1 nodes"),
        ("keys.1.scan", 0, "keys.1.scan: 0 does not come after 0"),
        ("keys.1.node", "keys.0.node", "two have the same node"),
        ("keys.0.node", 2**40, "keys.0.node: "),
        ("keys.0.submaps", [99], "keys.0.submaps: .* do not all exist"),
        ("keys.0.covariance.0.0", -1.0, "keys.0.covariance: not symmetric"),
        ("submaps.0.number", 1, "submaps: two have the same number|do not all exist"),
        ("submaps.0.keys.0", 10**6, "submaps.0.keys: 1000000 is not a key scan"),
        ("submaps.0.broken", 1, "submaps.0.broken: expected true or false"),
        ("constraints.0.first", 10**6, "constraints.0: connects 1000000 to"),
        ("constraints.0.information.0.1", 1e9, "constraints.0.information: not symmetric"),
        ("constraints.0.weight", 0.5, "constraints.0.weight: only a constraint of a loop"),
        ("constraints.0.loop", 10**6, "constraints.0.loop: 1000000 is not one of the"),
        ("loops.0.number", 5, "loops.0.number: is 5"),
        ("loops.0.submap", 99, "loops.0: joins submaps 99 and"),
        ("loops.0.agreeing", 1000, "loops.0.agreeing: 1000 of"),
        ("loops.0.believed", False, "loops.0.believed: is true for weights above 0.5 only"),
        ("loops.0.weight", 2.0, "loops.0.weight: "),
        ("loops.0.proposal", "guess", "loops.0.proposal: "),
        ("loops.0.colour", "red", "loops.0.colour: unknown key"),
    ],
)
def test_a_damaged_graph_is_refused_in_one_line(copy: Path, key: str, value: Any, complaint: str) -> None:
    path = copy / "graph.json"
    document = json.loads(path.read_text())
    *way, last = (int(step) if step.isdigit() else step for step in key.split("."))
    at = document
    for step in way:
        at = at[step]
    at[last] = document["keys"][0]["node"] if value == "keys.0.node" else value
    path.write_text(json.dumps(document))
    with pytest.raises(InputError, match=complaint) as error:
        RunRecord.open(copy).graph  # noqa: B018
    assert str(path) in str(error.value)
    assert "\n" not in str(error.value)


def test_a_file_that_is_not_a_graph_is_refused(lap_run: Path, tmp_path: Path) -> None:
    cut = tmp_path / "cut.json"
    cut.write_text((lap_run / "graph.json").read_text()[:1000])
    for wrong in (cut, tmp_path / "none.json", tmp_path, lap_run / "map.json", lap_run / "map.png"):
        with pytest.raises(InputError, match=str(wrong)) as error:
            read_graph(wrong)
        assert "\n" not in str(error.value)


def test_mapping_continues_in_the_closed_map(
    lap_run: Path, lap_log: Path, lap_path: list[Pose2D], tmp_path: Path
) -> None:
    """The log does not begin where the other run ended: the robot has to find its pose in the saved map first."""
    experiment = continue_mapping(replay_experiment(lap_log, load_scenario("replay")), lap_run / "map.json", "search")
    folder = experiment.run(tmp_path / "run", pictures=False).folder
    record = RunRecord.open(folder)
    assert record.traces.closed is not None
    assert record.traces.closed.shape == record.traces.estimate.shape
    true = np.array([pose.as_array() for pose in lap_path])
    found = record.traces.steps["lost"] == 0
    assert found.mean() > 0.5
    assert np.median(np.hypot(*(record.traces.estimate - true)[found, :2].T)) < 0.1
    assert record.saved_map is not None
    assert len(record.saved_map.mapper.map) < 1.3 * len(_map_of(lap_run))


def test_the_saved_state_lies_in_the_closed_map(lap_run: Path) -> None:
    record = RunRecord.open(lap_run)
    saved = record.saved_map
    assert saved is not None
    assert record.traces.closed is not None
    assert saved.T_map_base.distance(Pose2D.from_array(record.traces.closed[-1])) < 3e-6
    first_entries = np.array([pose.as_array() for pose, _ in saved.mapper.uncertainty.tiles.values()])
    apart = record.traces.closed[None, :, :2] - first_entries[:, None, :2]
    distances = np.hypot(*apart.transpose(2, 0, 1)).min(axis=1)
    assert distances.max() < 1e-5


def _map_of(folder: Path) -> SurfelMap:
    saved = RunRecord.open(folder).saved_map
    assert saved is not None
    return saved.mapper.map


def test_both_trajectories_are_scored(lap_run: Path, lap_path: list[Pose2D], tmp_path: Path) -> None:
    stamps = read_tum(lap_run / "closed.tum")[0].tolist()
    truth = tmp_path / "truth.tum"
    truth.write_text("".join(format_tum(stamp, pose) + "\n" for stamp, pose in zip(stamps, lap_path, strict=True)))
    result = CliRunner().invoke(app, ["eval", str(lap_run), "--reference", str(truth), "--no-align", "--json"])
    scores = json.loads(result.output)
    assert list(scores) == ["ATE", "RPE over 1 m", "closed: ATE", "closed: RPE over 1 m"]
    assert scores["closed: ATE"]["metres"]["rmse"] < scores["ATE"]["metres"]["rmse"]


def test_ctrl_c_ends_the_closing_and_leaves_the_run_unclosed(
    lap_log: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(slam: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("slam.run.closing_loops.finish", interrupted)
    folder = replay_experiment(lap_log, load_scenario("replay")).run(tmp_path / "run", pictures=False).folder
    record = RunRecord.open(folder)
    assert record.traces.closed is None
    assert record.saved_map is not None
    assert record.saved_map.T_map_base.distance(Pose2D.from_array(record.traces.estimate[-1])) < 2e-6
    assert record.metrics is not None
    assert any("Its loops were not closed at the end" in fault for fault in faults(record, record.metrics))
