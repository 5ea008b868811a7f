"""Every picture: nothing is cut off at its edge, and its line colours are distinct for the colour-blind."""

from __future__ import annotations

import re
from collections.abc import Callable
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

from slam.bench.match_report import MatcherComparison, draw_comparison
from slam.bench.match_score import BEAMS, MatchRuns
from slam.bench.paper import fig_3, fig_7, fig_8, fig_10, fig_21
from slam.config import ChiSquareConfig
from slam.env import top_view
from slam.lines.extraction import extract_segments
from slam.pose import FloatArray, Pose2D
from slam.run.calibration.calibrate import Calibration
from slam.run.calibration.report import draw_squares
from slam.run.calibration.wheel_fit import Leg, WheelFit
from slam.run.experiment_setup import scenario_experiment
from slam.run.pictures.figure_style import PAPER, save_figure
from slam.run.pictures.map_picture import MapContents, map_figure
from slam.run.pictures.scan_picture import draw_scan
from slam.run.pictures.world_picture import draw_world
from slam.run.report.animation import write_animation
from slam.run.report.figure_files import write_figures
from slam.run.report.run_plots import distance_figure, iterations_figure, timing_figure
from slam.run.results.run_record import RunRecord
from slam.run.viewer import palette
from slam.scan import LaserScan
from slam.scenario.file import load_scenario
from slam.sweep.report.groups import RunGroup
from slam.sweep.report.pictures import draw_bands, draw_boxes, draw_samples

Scanner = Callable[[FloatArray, Pose2D, int], LaserScan]

PAGE = Path(__file__).parents[1] / "slam/run/report/page.html"
MARGIN = 4
"""Pixels."""
LONG = "a scenario that has been given a rather long name, slam.matching.floor=0.025, seed 12345"
WORLDS = [(9.0, 6.0), (80.0, 1.5), (1.5, 80.0), (0.3, 0.2), (3000.0, 2000.0)]


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of 2.5 seconds in the paper's simulation."""
    folder = tmp_path_factory.mktemp("pictures") / "run"
    scenario_experiment(load_scenario("paper_simulation", ["duration=2.5"])).run(folder)
    return folder


def assert_nothing_is_cut(path: Path) -> None:
    """The frame of the picture is empty."""
    pixels = np.asarray(Image.open(path).convert("RGB")).astype(int)
    inner = pixels[MARGIN:-MARGIN, MARGIN:-MARGIN]
    frame = np.ones(pixels.shape[:2], np.bool_)
    frame[MARGIN:-MARGIN, MARGIN:-MARGIN] = False
    assert (pixels[frame] == 255).all(), path
    assert (inner < 128).any(), f"{path}: nothing is drawn"


@pytest.mark.parametrize("size", WORLDS)
def test_a_map_of_any_shape_is_whole(size: tuple[float, float], tmp_path: Path) -> None:
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]) * size
    way = np.column_stack([np.linspace(corners[0], corners[2], 50), np.zeros(50)])
    walls = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
    contents = MapContents(walls, way, way + 0.1 * max(size), way, [corners])
    save_figure(map_figure(contents), tmp_path / "map.png", dpi=100)
    assert_nothing_is_cut(tmp_path / "map.png")
    lone = MapContents(walls, way, way)  # without truth
    save_figure(map_figure(lone, longest=8.0), tmp_path / "lone.png", dpi=100)
    assert_nothing_is_cut(tmp_path / "lone.png")


@pytest.mark.parametrize("size", WORLDS)
def test_a_world_of_any_shape_is_whole(size: tuple[float, float], tmp_path: Path) -> None:
    x, y = size
    path = tmp_path / "room.yaml"
    path.write_text(
        f"name: room\nrobot: {{start: {{x: -1, y: -1}}}}\n"
        f"world: {{walls: [{{points: [[0, 0], [{x}, 0], [{x}, {y}]]}}]}}\n"
        f"route: {{waypoints: [[-1, {y + 1}], [{x}, {y + 1}]]}}\n"
        f"people: [{{waypoints: [[0, {y + 2}], [{x}, {y + 2}]], speed: 1.0}}]\n"
    )
    draw_world(tmp_path / "room.png", load_scenario(str(path)))
    assert_nothing_is_cut(tmp_path / "room.png")


def test_the_pictures_of_a_run_are_whole(run: Path) -> None:
    for name in ("map.png", "errors.png"):
        assert_nothing_is_cut(run / name)


def test_the_figures_of_the_paper_are_whole_png_and_pdf(run: Path, tmp_path: Path) -> None:
    count = write_figures([RunRecord.open(run)], tmp_path)
    names = {path.stem for path in tmp_path.iterdir()}
    assert {f"fig{number}" for number in range(15, 22)} | {"map", "errors", "distance", "timing"} <= names
    assert count == len(names)
    for name in names:
        assert_nothing_is_cut(tmp_path / f"{name}.png")
        pdf = (tmp_path / f"{name}.pdf").read_bytes()
        assert pdf.startswith(b"%PDF-")
        assert pdf.rstrip().endswith(b"%%EOF")


@pytest.mark.parametrize("count", [2, 7])
def test_runs_with_long_names_are_drawn_whole(run: Path, count: int, tmp_path: Path) -> None:
    runs = [(f"{number}: {LONG}", RunRecord.open(run).traces) for number in range(count)]
    figures = distance_figure(runs), iterations_figure(runs), timing_figure(runs)
    for number, figure in enumerate(figures):
        assert isinstance(figure, Figure)
        save_figure(figure, tmp_path / f"{number}.png")
        assert_nothing_is_cut(tmp_path / f"{number}.png")


def test_a_scan_with_a_long_name_is_drawn_whole(scan_of: Scanner, room: FloatArray, tmp_path: Path) -> None:
    scan = scan_of(room, Pose2D(2.0, 2.0), 0)
    draw_scan(tmp_path / "scan.png", scan.points(), extract_segments(scan, ChiSquareConfig()), f"{LONG}, {LONG}")
    assert_nothing_is_cut(tmp_path / "scan.png")


def test_the_pictures_of_benches_are_whole(tmp_path: Path) -> None:
    fig_3.draw(fig_3.measure(), tmp_path / "3.png")
    fig_7.draw(list(fig_7.measure(2)), tmp_path / "7.png")
    fig_8.draw(fig_8.measure(1), tmp_path / "8.png")
    fig_10.draw(tmp_path / "10.png")
    fig_21.draw(fig_21.measure(1.0), tmp_path / "21.png")
    runs = MatchRuns(np.full(9, 1e-3), np.zeros((9, 2)))
    names = [f"matcher {k} with a long name" for k in range(6)]
    near = {name: dict.fromkeys(BEAMS, runs) for name in names}
    draw_comparison(tmp_path / "match.png", MatcherComparison(near, {name: np.full((5, 7), 0.5) for name in names}, 9))
    for path in tmp_path.glob("*.png"):
        assert_nothing_is_cut(path)


def test_the_squares_of_a_calibration_are_drawn_whole(tmp_path: Path) -> None:
    leg = Leg(np.column_stack([np.linspace(0, 2, 9)] * 2 + [np.zeros(9)]), np.zeros((9, 3)))
    draw_squares(tmp_path / "squares.png", Calibration([leg] * 16, WheelFit(), 0.33, "the truth"))
    assert_nothing_is_cut(tmp_path / "squares.png")


def test_the_pictures_of_a_sweep_are_whole(tmp_path: Path) -> None:
    grids = [{"slam.matching.floor": 0.01 * k, "robot.odometry.travel_noise": 0.001 * k} for k in range(8)]
    groups = [RunGroup("a_scenario_of_a_long_name", "hopslam", grid) for grid in grids]
    for group in groups:
        group.values, group.curves = [0.1, 0.2, 300.0], [(9.0, [0.1, 0.2]), (9.0, [0.1, 0.3])]
        group.drawn = [{"robot.odometry.travel_noise": 0.1 * k} for k in range(3)]
    draw_boxes(tmp_path / "boxes.png", groups, "ate_rmse_m")
    draw_bands(tmp_path / "bands.png", groups)
    draw_samples(tmp_path / "samples.png", groups, "ate_rmse_m")
    for path in tmp_path.glob("*.png"):
        assert_nothing_is_cut(path)


@pytest.mark.parametrize("width", [200, 960])
def test_an_animation_contains_its_legend(run: Path, width: int, tmp_path: Path) -> None:
    """The names stand above the map, and leave the edges of the picture free."""
    write_animation(RunRecord.open(run), tmp_path / "map.webp", 1.0, width)
    pixels = np.asarray(Image.open(tmp_path / "map.webp").convert("L")).astype(int)
    assert (pixels[:2] > 235).all()
    assert (pixels[:30, -2:] > 235).all()


MACHADO = {
    "nobody": np.eye(3),
    "protanopia": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deuteranopia": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.01182, 0.04294, 0.968881]],
    "tritanopia": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.3039]],
}
"""Machado, Oliveira and Fernandes 2009, severity 1, on linear RGB."""
XYZ = np.array([[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.072175], [0.0193339, 0.119192, 0.9503041]])
APART = 25.0
"""Least difference of two colours (CIE 1976). The green and the red that were used before had only 10 and 20."""


def lab(colour: str, eyes: object) -> FloatArray:
    """Return L*, a* and b* (CIELAB, D65) of a colour #rrggbb as these eyes see it."""
    coded = np.array([int(colour[at : at + 2], 16) for at in (1, 3, 5)]) / 255.0
    linear = np.where(coded <= 0.04045, coded / 12.92, ((coded + 0.055) / 1.055) ** 2.4)
    xyz = XYZ @ np.clip(np.asarray(eyes) @ linear, 0.0, 1.0) / [0.95047, 1.0, 1.08883]
    f = np.where(xyz > (6 / 29) ** 3, np.cbrt(xyz), xyz / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def alike(colours: dict[str, str]) -> list[str]:
    """The pairs that somebody cannot tell apart."""
    return [
        f"{one} and {other} for {who}: {difference:.0f}"
        for one, other in combinations(colours, 2)
        for who, eyes in MACHADO.items()
        if (difference := float(np.linalg.norm(lab(colours[one], eyes) - lab(colours[other], eyes)))) < APART
    ]


def test_the_colour_distance_of_black_and_white_is_known() -> None:
    assert np.linalg.norm(lab("#ffffff", np.eye(3)) - lab("#000000", np.eye(3))) == pytest.approx(100.0, abs=0.01)
    assert len(alike({"slam": "#0a7d5a", "odometry": "#d1495b"})) == 2


def test_line_colours_of_pictures_are_distinct() -> None:
    names = ("slam", "odometry", "accent", "truth", "solid")
    assert not alike({"page": "#ffffff"} | {name: getattr(PAPER, name) for name in names if name != "solid"})
    assert not alike({name: getattr(PAPER, name) for name in names})
    assert len({PAPER.curve(k) for k in range(12)}) == 12


def test_report_colours_are_distinct_in_light_and_dark() -> None:
    themes = re.findall(r":root \{(.*?)\}", PAGE.read_text(), re.DOTALL)
    assert len(themes) == 2
    for theme in themes:
        colours = dict(re.findall(r"--([a-z]+): (#[0-9a-f]{6})", theme))
        assert not alike({name: colours[name] for name in ("card", "slam", "odometry", "truth")})
        assert not alike({name: colours[name] for name in ("card", "slam", "odometry", "accent")})


def test_line_colours_of_the_viewer_are_distinct() -> None:
    names = ("GROUND", "TRUE_WALLS", "MAP_LINES", "SLAM", "ODOMETRY", "TRUTH", "ROUTE")
    assert not alike({name: f"#{getattr(palette, name) >> 8:06x}" for name in names})
    assert not alike({str(k): f"#{colour >> 8:06x}" for k, colour in enumerate(palette.SERIES)})
    marks = {"start": palette.START_MARK, "end": palette.END_MARK, "none": palette.NO_SEGMENT}
    assert not alike({name: f"#{colour >> 8:06x}" for name, colour in marks.items()})


def test_line_colours_of_the_environment_are_distinct() -> None:
    names = ("_FLOOR", "_TRUTH", "_LINE", "_ESTIMATE", "_GOAL", "_PERSON")
    colours = {name: "#{:02x}{:02x}{:02x}".format(*getattr(top_view, name)) for name in names}
    assert not alike(colours)
