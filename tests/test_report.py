"""The report and its figures: self-contained, complete, and consistent with the run folder."""

import json
import re
import shutil
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
import yaml
from PIL import Image
from typer.testing import CliRunner

from slam.cli.main import app
from slam.errors import InputError
from slam.files.graphs.file import read_graph, write_graph
from slam.pose import Pose2D
from slam.run.experiment_setup import scenario_experiment
from slam.run.pictures.map_picture import contents_of, map_figure, transform_ends
from slam.run.report.animation import AppearingWalls, write_animation
from slam.run.report.faults import faults
from slam.run.report.page import metric_rows, write_report
from slam.run.report.run_section import changes, command, run_section
from slam.run.results.metric_table import METRICS
from slam.run.results.run_names import run_names
from slam.run.results.run_record import RunRecord
from slam.scenario.file import load_scenario
from slam.scenario.schema import Scenario

VOID = {"meta", "br", "img", "link", "hr", "input"}


class Page(HTMLParser):
    """The content of a page; checks that every tag is closed and that each id is used once."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.scrolling: list[bool] = []
        """For each open tag, True if its content can be scrolled sideways."""
        self.stuck: list[str] = []
        """Wide elements that cannot be scrolled."""
        self.ids: list[str] = []
        self.tags: set[str] = set()
        self.addresses: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        if tag in {"svg", "table"} and not any(self.scrolling):
            self.stuck.append(tag)
        if tag not in VOID:
            self.open.append(tag)
            self.scrolling.append(("class", "scroll") in attrs)
        self.note(attrs)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.note(attrs)

    def note(self, attrs: list[tuple[str, str | None]]) -> None:
        self.ids += [value for name, value in attrs if name == "id" and value]
        self.addresses += [v for name, v in attrs if v and "://" in v and not name.startswith("xmlns")]

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag
        self.scrolling.pop()


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the first 2.5 s of the paper's simulation."""
    folder = tmp_path_factory.mktemp("report") / "run"
    scenario_experiment(load_scenario("paper_simulation", ["duration=2.5"])).run(folder, pictures=False)
    return folder


@pytest.fixture(scope="module")
def own(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same time by the project's own method, which also saves its map."""
    folder = tmp_path_factory.mktemp("report") / "own"
    settings = ["duration=2.5", "slam={mode: hopslam}"]
    scenario_experiment(load_scenario("paper_simulation", settings)).run(folder, pictures=False)
    return folder


def page_of(*folders: Path) -> tuple[str, Page]:
    path = folders[0].parent / "page.html"
    write_report([RunRecord.open(folder) for folder in folders], path)
    text = path.read_text(encoding="utf-8")
    return text, Page(text)


def check_alone(text: str, page: Page) -> None:
    """Check that the page is complete, loads nothing, and that wide content can be scrolled on a narrow screen."""
    assert not page.open
    assert not page.stuck
    assert len(set(page.ids)) == len(page.ids)
    assert not page.addresses
    assert not page.tags & {"script", "link", "iframe"}
    assert not re.search(r"@import|url\((?!#)", text)
    used = re.findall(r'(?:url\(#|href="#)([^)"]+)', text)
    assert set(used) <= set(page.ids)


def test_a_page_is_self_contained(run: Path) -> None:
    text, page = page_of(run)
    check_alone(text, page)
    assert text.count("<svg") == 5
    assert "It did not arrive within the 2.5 s of the scenario." in text
    assert f"hopslam run {run}/config.yaml" in text
    assert "slam.matching.gamma_M" in text


def test_several_runs_are_compared(run: Path, own: Path) -> None:
    text, page = page_of(run, own)
    check_alone(text, page)
    assert "2 runs compared" in text
    assert 'class="number best"' in text
    assert text.count("<svg") == 3 + 2 * 5
    assert "standard deviations" in text  # only the own method estimates them


def copy_of(run: Path, folder: Path) -> Path:
    return Path(shutil.copytree(run, folder))


def test_a_killed_run_is_reported(run: Path, tmp_path: Path) -> None:
    killed = copy_of(run, tmp_path / "killed")
    (killed / "metrics.json").unlink()
    steps = (killed / "steps.csv").read_text().splitlines(keepends=True)
    (killed / "steps.csv").write_text("".join(steps[:10]))
    text, page = page_of(killed)
    check_alone(text, page)
    assert "it was killed, or is still going" in text
    assert "cut off" in text


def test_texts_of_files_are_escaped(run: Path, tmp_path: Path) -> None:
    wild = copy_of(run, tmp_path / "wild<script>alert(1)<")
    config = yaml.safe_load((wild / "config.yaml").read_text())
    config["description"] = '</p><script>alert("x")</script>'
    (wild / "config.yaml").write_text(yaml.safe_dump(config))
    metrics = json.loads((wild / "metrics.json").read_text())
    (wild / "metrics.json").write_text(json.dumps(metrics | {"error": "<script>", "log_report": "<script>"}))
    text, page = page_of(wild)
    assert "<script" not in text
    assert "&lt;script&gt;" in text
    check_alone(text, page)


def test_problems_are_found_and_named(run: Path, tmp_path: Path) -> None:
    """A gap in the scans, a lost robot, a stall."""
    bad = copy_of(run, tmp_path / "bad")
    record = RunRecord.open(bad)
    record.traces.stamps[12:] += 1.0
    record.traces.steps["lost"][5:8] = 1
    record.traces.steps["odometry_only"][8:10] = 1
    record.traces.steps["mapped"][9] = 0
    record.traces.steps["v"][:] = 0.4
    record.traces.odometry[:] = record.traces.odometry[0]
    text = " ".join(faults(record, {"ending": "collided", "wall_free_air_m": 2.54, "wall_phantom_m": 0.9}))
    for part in (
        "hit something",
        "2.5 m of walls in free air, of which 0.9 m in one piece",
        "3 of 25 scans: the robot was lost",
        "1 of 25 scans: no match could be trusted",
        "Gaps of more than 1.8 scan periods of 0.1 s: 1, from",
        "(stall)",
    ):
        assert part in text


def test_the_best_run_is_marked_only_if_unique() -> None:
    runs = [{"ate_rmse_m": error, "scans": 5, "ending": "arrived"} for error in (0.2, 0.1)]
    table = {metric.key: cells for metric, cells, *_ in metric_rows(runs)}
    assert [cell.best for cell in table["ate_rmse_m"]] == [False, True]
    assert not any(cell.best for cell in table["scans"])
    walls = [{"wall_recall": share, "ending": "arrived"} for share in (0.9, 0.8)]
    assert [cell.best for _, cells, *_ in metric_rows(walls) for cell in cells] == [True, False]  # more is better
    same = metric_rows([runs[0], runs[0]])
    assert not any(cell.best for _, cells, *_ in same for cell in cells)


@pytest.mark.parametrize("ending", ["collided", "failed", "interrupted", None])
def test_an_interrupted_run_is_never_marked_best(ending: str | None) -> None:
    whole = [{"ate_rmse_m": error, "ending": "arrived"} for error in (0.3, 0.2)]
    short = {"ate_rmse_m": 0.1} | ({"ending": ending} if ending else {})
    for runs, best in (([short, *whole], [False, False, True]), ([short, whole[0]], [False, False])):
        (_, cells, *_), *_ = metric_rows(runs)
        assert [cell.best for cell in cells] == best


def test_runs_of_one_name_are_distinguished(run: Path, tmp_path: Path) -> None:
    """The name shows the seed, a setting or the date that differs, and the folder if all else is equal."""
    folders = [copy_of(run, tmp_path / str(number)) for number in range(4)]
    for folder, given in zip(folders, ({}, {"seed": 7}, {"duration": 9.0}, {}), strict=True):
        config = yaml.safe_load((folder / "config.yaml").read_text())
        (folder / "config.yaml").write_text(yaml.safe_dump(config | given))
    metrics = json.loads((folders[3] / "metrics.json").read_text())
    (folders[3] / "metrics.json").write_text(json.dumps(metrics | {"began": "2031-02-03T04:05:06+00:00"}))
    records = [RunRecord.open(folder) for folder in folders]
    names = run_names(records)
    assert len(set(names)) == 4
    assert "seed 7" in names[1]
    assert "duration=9.0" in names[2]
    assert "2031-02-03 04:05:06" in names[3]
    assert len(set(run_names([records[0], RunRecord.open(copy_of(run, tmp_path / "again"))]))) == 2
    assert run_names([records[0]]) == ["paper_simulation"]
    write_report(records, tmp_path / "page.html")
    text = (tmp_path / "page.html").read_text()
    assert all(text.count(name) >= 3 for name in names)


def test_every_number_of_a_run_has_a_meaning(run: Path) -> None:
    assert {"ate_rmse_m", "scans", "slam_ms_p99"} <= set(METRICS)
    assert all(metric.meaning.endswith(".") for metric in METRICS.values())


def test_only_settings_that_differ_from_defaults_are_listed() -> None:
    assert changes(Scenario(name="x")) == []
    changed = changes(Scenario.model_validate({"name": "x", "slam": {"mode": "paper", "lines": {"psi": 0}}}))
    assert [change.key for change in changed] == ["slam.mode", "slam.lines.psi"]


@pytest.mark.parametrize("kind", ["webp", "gif"])
def test_an_animation_grows_frame_by_frame(kind: str, run: Path, tmp_path: Path) -> None:
    path = tmp_path / f"map.{kind}"
    write_animation(RunRecord.open(run), path, seconds=1.0, width=240)
    with Image.open(path) as film:
        dark = []
        for number in range(film.n_frames):
            film.seek(number)
            dark.append(int((np.asarray(film.convert("L")) < 80).sum()))
    assert len(dark) == 10
    assert dark[-1] > 1.3 * dark[0]


def test_an_animation_needs_a_known_file_extension(run: Path) -> None:
    with pytest.raises(InputError, match=r"\.webp or \.gif"):
        write_animation(RunRecord.open(run), run / "map.mp4")


def test_each_wall_appears_once_when_seen() -> None:
    lines = AppearingWalls(np.array([[[0.0, 0.0], [1.0, 0.0]]]))
    points = np.column_stack([np.linspace(0.0, 0.5, 20), np.zeros(20)])
    first = lines.seen(0, points)
    assert 0.4 < first[:, :, 0].max() < 0.7
    assert len(lines.seen(1, points)) == 0
    assert len(lines.seen(2, points + np.array([0.5, 0.0]))) > 3


def test_the_commands_print_their_file_names(own: Path, tmp_path: Path) -> None:
    runner = CliRunner()
    page, film = tmp_path / "r.html", tmp_path / "m.webp"
    done = runner.invoke(app, ["report", str(own), "--out", str(page)], catch_exceptions=False)
    assert f"report in {page}" in done.stdout.replace("\n", "")
    animated = ["animate", str(own), "--out", str(film), "--seconds", "1", "--width", "200"]
    assert runner.invoke(app, animated, catch_exceptions=False).exit_code == 0
    assert page.is_file()
    assert film.is_file()
    wrong = runner.invoke(app, ["report", str(own), "--out", str(tmp_path / "no" / "r.html")])
    assert "choose another place" in str(wrong.exception)


def test_the_command_that_repeats_a_run_is_exact(own: Path) -> None:
    record = RunRecord.open(own)
    config = own / "config.yaml"
    mapped = {"map": "m.json", "start": "search"}
    assert command(record, mapped) == f"hopslam run {config} --map m.json --start search"
    assert command(record, {"log": "a.log", "sure_after_s": 1.0, "map": "m.json"}) == (
        f"hopslam localize a.log --scenario {config} --map m.json"
    )
    assert command(record, {"backend": "hardware", "dry_run": True}) == (
        f"hopslam run {config} --backend hardware --dry-run"
    )


def test_a_closed_run_is_shown_with_its_loops(lap_run: Path, tmp_path: Path) -> None:
    write_report([RunRecord.open(lap_run)], tmp_path / "a.html")
    page = (tmp_path / "a.html").read_text()
    assert "The map by odometry and matching alone, without loops" in page
    graph = read_graph(lap_run / "graph.json")
    assert f"All {len(graph.loops)} loops, {graph.believed.sum()} believed" in page
    assert "not believed" not in page


def test_doubtful_loops_are_described_and_listed_first(lap_run: Path, tmp_path: Path) -> None:
    copy = shutil.copytree(lap_run, tmp_path / "run")
    graph = read_graph(copy / "graph.json")
    weights = np.append(0.1, graph.weights[1:])
    write_graph(copy / "graph.json", replace(graph, weights=weights))
    record = RunRecord.open(copy)
    write_report([record], tmp_path / "a.html")
    page = (tmp_path / "a.html").read_text()
    assert "✗ not believed" in page
    assert "loop not believed</span>" in page
    rows = run_section(record, "run1", "run").loops
    assert [row.believed for row in rows] == [False] + [True] * (len(graph.loops) - 1)
    labels = map_figure(contents_of(record)).axes[0].get_legend_handles_labels()[1]
    assert {"loop", "loop not believed"} <= set(labels)


def test_segments_are_moved_with_their_scans() -> None:
    """The expected ends come from Pose2D, one segment at a time."""
    rng = np.random.default_rng(0)
    poses, ends = rng.normal(size=(5, 3)), rng.normal(size=(5, 2, 2))
    expected = [Pose2D(*pose).transform(line) for pose, line in zip(poses, ends, strict=True)]
    np.testing.assert_allclose(transform_ends(poses, ends), expected, atol=1e-12)
