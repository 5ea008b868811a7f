"""Exports, each read back by an independent library and replayed to the same run."""

import csv
import json
import shutil
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
import yaml
from PIL import Image
from rosbags.highlevel import AnyReader
from shapely.geometry import shape

from slam.errors import InputError
from slam.files.logs import read_log
from slam.files.tum import read_tum
from slam.pose import FloatArray, relative_poses
from slam.run.experiment_setup import replay_experiment, scenario_experiment
from slam.run.export.formats import FORMATS, Format, export
from slam.run.occupancy import count_rays
from slam.run.results.run_record import RunRecord
from slam.scenario.file import load_scenario

SETTINGS = ["duration=8", "route.waypoints=[[2, 0], [2, 0.7], [0, 0]]"]


@pytest.fixture(scope="module")
def record(tmp_path_factory: pytest.TempPathFactory) -> RunRecord:
    """Eight seconds in the corridor, driving and turning."""
    out = tmp_path_factory.mktemp("run") / "run"
    return RunRecord.open(scenario_experiment(load_scenario("corridor", SETTINGS)).run(out, pictures=False).folder)


def test_every_format_that_is_offered_is_written_and_no_other() -> None:
    assert set(FORMATS) == set(get_args(Format))


@pytest.mark.filterwarnings("ignore")  # evo's imports
def test_evo_reads_the_tum_file(record: RunRecord, tmp_path: Path) -> None:
    from evo.tools.file_interface import read_tum_trajectory_file

    export(record, "tum", tmp_path / "a.tum")
    trajectory = read_tum_trajectory_file(tmp_path / "a.tum")
    np.testing.assert_allclose(trajectory.timestamps, record.traces.stamps, atol=1e-6)
    np.testing.assert_allclose(trajectory.positions_xyz[:, :2], record.traces.final[:, :2], atol=1e-6)


def test_csv_has_a_row_for_each_scan(record: RunRecord, tmp_path: Path) -> None:
    export(record, "csv", tmp_path / "a.csv")
    with (tmp_path / "a.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(record.traces.stamps)
    assert record.traces.truth is not None
    for name, poses in (("x", record.traces.estimate), ("truth_x", record.traces.truth)):
        np.testing.assert_allclose([float(row[name]) for row in rows], poses[:, 0], atol=1e-6)
    assert {"odometry_theta", "iterations", "cov_thth"} <= rows[0].keys()


@pytest.mark.filterwarnings("ignore")  # ezdxf's imports
def test_the_line_map_is_the_same_in_geojson_dxf_and_svg(record: RunRecord, tmp_path: Path) -> None:
    import ezdxf

    for to in ("geojson", "dxf", "svg"):
        export(record, to, tmp_path / f"a.{to}")
    features = json.loads((tmp_path / "a.geojson").read_text())["features"]
    lines = np.array([shape(feature["geometry"]).coords for feature in features])
    np.testing.assert_allclose(lines, record.walls, atol=1e-4)
    drawing = ezdxf.readfile(tmp_path / "a.dxf")
    assert drawing.units == 6
    walls = [(e.dxf.start.vec2, e.dxf.end.vec2) for e in drawing.modelspace().query("LINE[layer=='WALLS']")]
    np.testing.assert_allclose(np.array(walls), record.walls, atol=1e-9)
    assert len(drawing.modelspace().query("LWPOLYLINE[layer=='TRAJECTORY']").first) == len(record.traces.stamps)
    assert (tmp_path / "a.svg").read_text().count("<line ") == len(record.walls)


def test_svg_is_xml(record: RunRecord, tmp_path: Path) -> None:
    from xml.etree import ElementTree

    export(record, "svg", tmp_path / "a.svg")
    root = ElementTree.parse(tmp_path / "a.svg").getroot()
    walls = root.find(".//*[@id='walls']")
    assert walls is not None
    ends = np.array([[float(line.attrib[key]) for key in ("x1", "y1", "x2", "y2")] for line in walls])
    np.testing.assert_allclose(ends, record.walls.reshape(-1, 4), atol=1e-3)


def load_map(folder: Path) -> tuple[dict[str, Any], FloatArray]:
    """A map as nav2's map_server takes it: occupied 100, free 0, unknown -1, the lowest row first."""
    header = yaml.safe_load((folder / "map.yaml").read_text())
    grey = np.asarray(Image.open(folder / header["image"]), float)[::-1]
    dark = (255.0 - grey) / 255.0
    return header, np.where(dark >= header["occupied_thresh"], 100, np.where(dark <= header["free_thresh"], 0, -1))


def test_a_ros_map_is_free_on_the_path_and_occupied_at_walls(record: RunRecord, tmp_path: Path) -> None:
    export(record, "ros", tmp_path / "map")
    header, cells = load_map(tmp_path / "map")
    assert set(np.unique(cells)) == {-1, 0, 100}

    def at(points: FloatArray) -> FloatArray:
        column, row = ((points - header["origin"][:2]) / header["resolution"]).astype(int).T
        return cells[row, column]

    assert (at(record.traces.estimate[:, :2]) == 0).all()
    long = record.walls[np.hypot(*np.diff(record.walls, axis=1)[:, 0].T) > 1.0]
    along = np.linspace(0.2, 0.8, 20)[:, None, None]
    near = np.stack([at(((1 - along) * long[:, 0] + along * long[:, 1] + shift).reshape(-1, 2)) for shift in
                     np.array([[0, 0], [0, 0.05], [0, -0.05], [0.05, 0], [-0.05, 0]])])  # fmt: skip
    assert (near == 100).any(axis=0).mean() > 0.95


def plain_cells(start: FloatArray, end: FloatArray) -> set[tuple[int, int]]:
    """Cells (row, column) on the way, by going along it in small steps."""
    way = start + np.linspace(0.0, 1.0, 20001)[:, None] * (end - start)
    return {(int(y), int(x)) for x, y in np.floor(way)}


@pytest.mark.parametrize("seed", range(20))
def test_rays_mark_every_cell_they_cross(seed: int) -> None:
    start, end = np.random.default_rng(seed).uniform(0.0, 30.0, (2, 2))
    passes, hits = np.zeros((30, 30), np.int32), np.zeros((30, 30), np.int32)
    count_rays(passes, hits, np.zeros(2), 1.0, start, end[None], np.array([True]))
    last = int(end[1]), int(end[0])
    assert hits[last] == hits.sum() == 1
    assert passes.max(initial=0) <= 1
    walked = {(int(row), int(column)) for row, column in np.argwhere(passes)} | {last}
    assert plain_cells(start, end) <= walked  # small steps miss cells whose corners are cut
    assert len(walked) == abs(last[0] - int(start[1])) + abs(last[1] - int(start[0])) + 1


@pytest.mark.parametrize("to", ["mcap", "rosbag2"])
def test_rosbags_reads_the_bags(record: RunRecord, tmp_path: Path, to: str) -> None:
    out = tmp_path / ("bag" if to == "rosbag2" else "a.mcap")
    export(record, to, out)
    with AnyReader([out]) as reader:
        counts = {topic: info.msgcount for topic, info in reader.topics.items()}
        first = next(reader.deserialize(data, c.msgtype) for c, _, data in reader.messages() if c.topic == "/scan")
    K = len(record.traces.stamps)
    assert counts == {"/scan": K, "/odom": K, "/tf": K, "/ground_truth": K, "/tf_static": 1}
    assert (first.header.frame_id, len(first.ranges)) == ("laser", 682)


def test_graphslam_reads_the_g2o_file(lap_run: Path, tmp_path: Path) -> None:
    graphslam = pytest.importorskip("graphslam.graph")
    export(RunRecord.open(lap_run), "g2o", tmp_path / "a.g2o")
    read, graph = graphslam.Graph.from_g2o(tmp_path / "a.g2o"), RunRecord.open(lap_run).graph
    assert graph is not None
    poses = np.array([vertex.pose.to_array() for vertex in read._vertices])
    np.testing.assert_allclose(poses, graph.nodes, atol=1e-12)
    chi_squared = [_g2o_chi_squared(edge) for edge in read._edges]
    np.testing.assert_allclose(chi_squared, graph.edge_weights * graph.chi_squared, rtol=1e-6, atol=1e-9)
    assert read.calc_chi2() == pytest.approx(sum(chi_squared), rel=1e-3)  # its error has the axes of the second node


def _g2o_chi_squared(edge: Any) -> float:
    """chi^2 of an edge as EdgeSE2 of g2o has it: the error is measured^-1 (first^-1 second)."""
    first, second, measured = (p.to_array() for p in (edge.vertices[0].pose, edge.vertices[1].pose, edge.estimate))
    error = relative_poses(measured, relative_poses(first, second))
    return float(error @ edge.information @ error)


def test_a_run_without_loops_has_no_graph_to_export(record: RunRecord, tmp_path: Path) -> None:
    shutil.copytree(record.folder, tmp_path / "run")
    (tmp_path / "run" / "graph.json").unlink()
    with pytest.raises(InputError, match=r"has no graph.json"):
        export(RunRecord.open(tmp_path / "run"), "g2o", tmp_path / "a.g2o")


def test_exports_have_the_final_results(lap_run: Path, tmp_path: Path) -> None:
    record = RunRecord.open(lap_run)
    export(record, "tum", tmp_path / "a.tum")
    export(record, "csv", tmp_path / "a.csv")
    np.testing.assert_allclose(read_tum(tmp_path / "a.tum")[1], read_tum(lap_run / "closed.tum")[1], atol=2e-9)
    with (tmp_path / "a.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert record.traces.closed is not None
    np.testing.assert_allclose([float(row["closed_x"]) for row in rows], record.traces.closed[:, 0], atol=1e-6)
    np.testing.assert_allclose([float(row["x"]) for row in rows], record.traces.estimate[:, 0], atol=1e-6)


@pytest.mark.parametrize("to", ["carmen", "mcap", "rosbag2"])
def test_an_exported_run_replays_to_the_same_run(record: RunRecord, tmp_path: Path, to: str) -> None:
    export(record, to, tmp_path / "log")
    again = replay_experiment(tmp_path / "log", load_scenario("corridor", SETTINGS)).run(
        tmp_path / "again", pictures=False
    )
    stamps, poses = read_tum(again.folder / "trajectory.tum")
    np.testing.assert_array_equal(stamps, record.traces.stamps)
    np.testing.assert_allclose(poses, record.traces.estimate, atol=1e-3)


def test_a_carmen_log_states_the_missing_fields(record: RunRecord, tmp_path: Path) -> None:
    export(record, "carmen", tmp_path / "a.log")
    log, whole = read_log(tmp_path / "a.log"), read_log(record.folder)
    assert log.ignored.keys() == {"ODOM", "TRUEPOS"}
    assert log.time_increment == pytest.approx(whole.time_increment, rel=1e-9)
    assert log.lidar.range_min == pytest.approx(whole.lidar.range_min)
    assert log.twists == pytest.approx(whole.twists, abs=1e-8)
    np.testing.assert_array_equal(np.isposinf(log.ranges), np.isposinf(whole.ranges))


def test_an_interrupted_run_is_exported(record: RunRecord, tmp_path: Path) -> None:
    cut = tmp_path / "cut"
    cut.mkdir()
    for file in record.folder.iterdir():
        if file.name not in {"metrics.json", "map.json"}:
            (cut / file.name).write_bytes(file.read_bytes())
    (cut / "log.mcap").write_bytes((record.folder / "log.mcap").read_bytes()[:40_000])
    for to in ("mcap", "ros", "carmen", "geojson"):
        export(RunRecord.open(cut), to, tmp_path / f"a.{to}")
    with AnyReader([tmp_path / "a.mcap"]) as reader:
        assert 5 < reader.topics["/scan"].msgcount < len(record.traces.stamps)


def test_runs_that_cannot_be_exported_are_refused(record: RunRecord, tmp_path: Path) -> None:
    (tmp_path / "there").write_text("")
    with pytest.raises(InputError, match="already there; add --force to replace it, or choose another"):
        export(record, "tum", tmp_path / "there")
    with pytest.raises(InputError, match="a folder that is already there"):
        export(record, "tum", tmp_path, force=True)
    export(record, "tum", tmp_path / "there", force=True)
    assert (tmp_path / "there").stat().st_size
    (tmp_path / "there").write_text("")
    with pytest.raises(InputError, match="no such format; there are tum, csv, ros"):
        export(record, "pdf", tmp_path / "new")
    with pytest.raises(InputError, match="cannot be written: File exists"):
        export(record, "tum", tmp_path / "there" / "a.tum")
