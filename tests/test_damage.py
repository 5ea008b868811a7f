"""Damaged run and sweep folders: intact parts are read, damage is named; one mistake has one exit code."""

import json
import shutil
from pathlib import Path

import pytest
from typer.testing import CliRunner

from slam.cli.main import app
from slam.errors import HopslamError, InputError
from slam.files.logs import read_log
from slam.run.results.run_record import RunRecord
from slam.sweep.folder import Folder
from slam.sweep.report.write import write_report
from slam.sweep.result_store import RESULTS, ResultStore
from tests.fuzz_seeds import MESSAGE, SQLITE, mcap, ros1_bag, ros2_bag, run_folder, sweep_folder, sweep_row


@pytest.fixture(scope="module")
def whole_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("whole")
    run_folder(folder)
    return folder / "run"


@pytest.fixture
def run(whole_run: Path, tmp_path: Path) -> Path:
    """The folder of a run of four scans, to be damaged."""
    return Path(shutil.copytree(whole_run, tmp_path / "run"))


def cut(path: Path, end: int) -> None:
    path.write_bytes(path.read_bytes()[:end])


@pytest.mark.parametrize("name", ["trajectory.tum", "odometry.tum", "groundtruth.tum", "steps.csv"])
def test_a_run_is_read_up_to_a_truncated_line(run: Path, name: str) -> None:
    cut(run / name, -30)
    record = RunRecord.open(run)
    assert len(record.traces.stamps) == 3
    assert len(record.damage) == 1
    assert name in record.damage[0]
    assert "line" in record.damage[0]


def test_a_truncated_line_map_is_read_up_to_its_end(run: Path) -> None:
    whole = len(RunRecord.open(run).segments[0])
    cut(run / "lines.geojson", -20)
    record = RunRecord.open(run)
    assert len(record.segments[0]) == whole - 1
    assert record.damage == [f"{run / 'lines.geojson'}: damaged after segment {whole - 1}"]


def test_commands_warn_of_damage_and_continue(run: Path) -> None:
    cut(run / "steps.csv", -30)
    for command in (["report", str(run)], ["export", str(run), "--to", "tum", "--out", str(run / "a.tum")]):
        done = CliRunner().invoke(app, command)
        assert done.exit_code == 0, done.output
        assert "warning: steps.csv: line 5 is" in done.stderr
    assert "steps.csv: line 5 is" in (run / "report.html").read_text()


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("[1]", "is not an object"),
        ('{"scans": "a"}', "'a' is not a number"),
        ('{"began": "x"}', "not a date"),
        ("{", "Expec"),
    ],
)
def test_invalid_metrics_are_refused(run: Path, text: str, fault: str) -> None:
    (run / "metrics.json").write_text(text)
    with pytest.raises(InputError, match=rf"metrics\.json: .*{fault}.*remove it"):
        RunRecord.open(run)


@pytest.mark.parametrize(
    "command",
    ["export RUN --to tum --out FILE/a", "report RUN --out FILE/a", "animate RUN --out FILE/a.gif",
     "optimize RUN --out FILE/a", "export NO --to tum --out a", "report NO", "animate NO", "optimize NO", "eval NO"],
)  # fmt: skip
def test_one_mistake_has_one_exit_code_in_all_commands(run: Path, tmp_path: Path, command: str) -> None:
    (tmp_path / "file").write_text("")
    words = {"RUN": str(run), "NO": str(tmp_path / "no")}
    done = CliRunner().invoke(app, [words.get(w, w).replace("FILE", str(tmp_path / "file")) for w in command.split()])
    assert isinstance(done.exception, HopslamError)
    assert done.exception.exit_code == 2


def test_a_damaged_row_is_set_aside_and_named(tmp_path: Path) -> None:
    sweep_folder(tmp_path)
    (tmp_path / "rows" / f"{3:016x}.json").write_text('{"id": "3"}')
    (tmp_path / "rows" / "x.json").write_text(json.dumps(sweep_row(5)))
    store = ResultStore(Folder(str(tmp_path)))
    said = store.set_damaged_aside()
    assert [name for name in (f"{3:016x}.json", "x.json") if any(name in text for text in said)] == [
        f"{3:016x}.json", "x.json",
    ]  # fmt: skip
    store.compact()
    assert store.done() == {f"{seed:016x}" for seed in range(3)}
    assert (tmp_path / "rows" / ".damaged-x.json").is_file()


def test_undamaged_results_are_kept(tmp_path: Path) -> None:
    sweep_folder(tmp_path)
    cut(tmp_path / RESULTS, -50)
    with pytest.raises(InputError, match="damaged, or not the results of a sweep"):
        list(ResultStore(Folder(str(tmp_path))).rows())
    report = write_report(str(tmp_path))
    assert ["results.parquet: damaged, 0 rows are whole" in text for text in report.damage] == [True]
    assert ResultStore(Folder(str(tmp_path))).done() == {f"{3:016x}"}  # that of the journal


def test_symbolic_links_in_a_sweep_are_allowed(tmp_path: Path) -> None:
    sweep_folder(tmp_path / "real")
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "real" / "report").symlink_to(tmp_path / "elsewhere")
    (tmp_path / "link").symlink_to(tmp_path / "real")
    assert Path(write_report(str(tmp_path / "link")).page).is_file()
    assert not list((tmp_path / "elsewhere").iterdir())


def test_a_damaged_chunk_loses_no_other_chunk(tmp_path: Path) -> None:
    mcap(tmp_path)
    ros1_bag(tmp_path)
    for name in ("ZSTD.mcap", "bz2.bag"):
        path = tmp_path / name
        scans, data = len(read_log(path)), bytearray(path.read_bytes())
        at = data.find(b"BZh") + 40 if name == "bz2.bag" else data.find(b"\x28\xb5\x2f\xfd") + 30
        data[at] ^= 255
        path.write_bytes(data)
        log = read_log(path)
        assert "1 damaged chunk skipped (first at byte" in log.report
        assert 0 < len(log) <= scans


def test_a_damaged_packed_message_loses_no_other(tmp_path: Path) -> None:
    ros2_bag(tmp_path, SQLITE, MESSAGE)
    file = next((tmp_path / "bag").glob("*.db3"))
    data = file.read_bytes()
    file.write_bytes(data.replace(b"\x28\xb5\x2f\xfd", b"\x29\xb5\x2f\xfd", 1))
    log = read_log(tmp_path / "bag")
    assert len(log) in (3, 4)
    assert "1 damaged message skipped" in log.report
