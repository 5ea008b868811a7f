"""Sweeps that are run by the pool, resumed, killed, reported and repeated."""

import json
from collections.abc import Iterator
from contextlib import closing
from multiprocessing import active_children
from pathlib import Path

import pytest
from typer.testing import CliRunner

from slam.cli.main import app
from slam.sweep.executor import FinishedJob, LostJob
from slam.sweep.folder import Folder
from slam.sweep.job import Job
from slam.sweep.make_plan import make_plan
from slam.sweep.process_pool import ProcessPool
from slam.sweep.report.groups import RunGroup
from slam.sweep.report.tables import tables
from slam.sweep.report.write import worst_runs
from slam.sweep.result_rows import job_columns
from slam.sweep.result_store import ResultStore
from slam.sweep.run_job import run_job
from slam.sweep.scheduler import Scheduler


class UnreliableExecutor:
    """An executor that runs nothing: the first tries of some jobs are lost, and one job fails always."""

    def __init__(self, jobs: list[Job], lost: int, interrupt_after: int = 10**9) -> None:
        self._left = {job.id: lost for job in jobs[::2]}
        self._bad, self._jobs, self._until = jobs[-1].id, list[Job](), interrupt_after

    @property
    def free(self) -> int:
        return 3 - len(self._jobs)

    @property
    def busy(self) -> int:
        return len(self._jobs)

    def submit(self, job: Job) -> None:
        self._jobs.append(job)

    def collect(self, timeout: float) -> Iterator[FinishedJob | LostJob]:
        job = self._jobs.pop(0)
        self._until -= 1
        if self._until < 0:
            raise KeyboardInterrupt
        if self._left.get(job.id, 0) > 0:
            self._left[job.id] -= 1
            yield LostJob(job, "the worker died")
        else:
            status = "failed" if job.id == self._bad else "done"
            yield FinishedJob(job, job_columns(job) | {"status": status, "error": None})

    def close(self) -> None:
        self._jobs.clear()


@pytest.mark.parametrize(("lost", "retry", "failed"), [(0, 0, 1), (2, 2, 1), (2, 1, 6)])
def test_each_job_has_one_row_whatever_fails(tmp_path: Path, lost: int, retry: int, failed: int) -> None:
    """Five of ten jobs lose their worker ``lost`` times; the last job fails."""
    jobs = list(make_plan(["paper_simulation"], {"seeds": "0:10"}).jobs())
    executor, store = UnreliableExecutor(jobs, lost), ResultStore(Folder(str(tmp_path)))
    scheduler = Scheduler(executor, store, retry, lambda done, failed: None)
    assert not scheduler.run(iter(jobs))
    assert (scheduler.done, scheduler.failed) == (10, failed)
    assert sorted(row["id"] for row in store.rows()) == sorted(job.id for job in jobs)
    assert {row["tries"] for row in store.rows()} == {1, lost + 1 if failed == 1 else retry + 1, retry + 1}


def test_results_before_ctrl_c_are_kept(tmp_path: Path) -> None:
    jobs = list(make_plan(["paper_simulation"], {"seeds": "0:10"}).jobs())
    executor, store = UnreliableExecutor(jobs, 0, interrupt_after=4), ResultStore(Folder(str(tmp_path)))
    assert Scheduler(executor, store, 0, lambda done, failed: None).run(iter(jobs))
    assert len(store.done()) == 4


@pytest.fixture(scope="module")
def sweep(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small sweep, made by the command in one process."""
    out = tmp_path_factory.mktemp("sweep") / "out"
    words = ["sweep", "paper_simulation", "--seeds", "0:2", "--mode", "hopslam,dead_reckoning", "--set", "duration=1"]
    done = CliRunner().invoke(app, [*words, "--grid", "physics.rate=240,480", "--jobs", "1", "--out", str(out)])
    assert done.exit_code == 0, done.output
    assert "8 runs done, 0 of them failed" in done.output
    return out


def test_a_sweep_leaves_a_table_and_ordinary_run_folders(sweep: Path) -> None:
    rows = list(ResultStore(Folder(str(sweep))).rows())
    assert len({row["id"] for row in rows}) == 8
    assert {(row["mode"], row["seed"], row["set.physics.rate"]) for row in rows} == {
        (mode, seed, rate) for mode in ("hopslam", "dead_reckoning") for seed in (0, 1) for rate in (240, 480)
    }
    for row in rows:
        folder = sweep / "runs" / row["id"]
        metrics = json.loads((folder / "metrics.json").read_text())
        assert metrics["ate_rmse_m"] == row["ate_rmse_m"]
        assert metrics["seed"] == row["seed"]
        assert not (folder / "map.png").exists()
    reckoned = [row for row in rows if row["mode"] == "dead_reckoning"]
    assert all(row["ate_rmse_m"] == pytest.approx(row["odometry_ate_rmse_m"], abs=1e-6) for row in reckoned)
    assert not list((sweep / "runs").glob(".draft*"))


def test_a_restarted_sweep_runs_only_what_is_missing(sweep: Path) -> None:
    before = {row["id"]: row["started"] for row in ResultStore(Folder(str(sweep))).rows()}
    words = ["sweep", str(sweep / "sweep.yaml"), "--out", str(sweep)]
    done = CliRunner().invoke(app, [*words, "--seeds", "0:3", "--plan"])
    assert "12 runs, 4 of them to do" in " ".join(done.output.split())
    done = CliRunner().invoke(app, words)
    assert "0 runs done" in done.output
    assert {row["id"]: row["started"] for row in ResultStore(Folder(str(sweep))).rows()} == before


def test_the_report_is_one_file_with_pictures(sweep: Path) -> None:
    done = CliRunner().invoke(app, ["sweep", "report", str(sweep)])
    assert done.exit_code == 0, done.output
    assert "hopslam run paper_simulation --seed" in done.output
    page = (sweep / "report" / "report.html").read_text()
    assert page.count("data:image/png;base64,") == 2
    assert 'src="http' not in page
    assert "dead_reckoning, rate=480" in page
    for name in ("boxes.png", "bands.png"):
        assert (sweep / "report" / name).read_bytes().startswith(b"\x89PNG")
    wrong = CliRunner().invoke(app, ["sweep", "report", str(sweep), "--metric", "ate_rmse"])
    assert "did you mean ate_rmse_m?" in str(wrong.exception)


def test_a_row_that_is_run_again_has_the_same_bits(sweep: Path) -> None:
    row = next(row for row in ResultStore(Folder(str(sweep))).rows() if row["mode"] == "hopslam")
    done = CliRunner().invoke(app, ["sweep", "repeat", str(sweep), row["id"]])
    assert done.exit_code == 0, done.output
    assert "the same, bit for bit" in done.output
    assert row["command"] in done.output
    assert (sweep / "repeated" / row["id"] / "trajectory.tum").read_bytes() == (
        sweep / "runs" / row["id"] / "trajectory.tum"
    ).read_bytes()


def test_a_killed_worker_is_replaced_and_its_job_repeated(tmp_path: Path) -> None:
    changes = {"settings": {"duration": 0.5}, "modes": ["dead_reckoning"], "seeds": "0:8"}
    plan = make_plan(["paper_simulation"], changes)
    pool, store = ProcessPool(2, str(tmp_path / "runs"), pictures=False), ResultStore(Folder(str(tmp_path)))
    killed: list[int] = []

    def kill(done: int, failed: int) -> None:
        if done > 1 and not killed:
            worker = active_children()[0]
            killed.append(worker.pid or 0)
            worker.kill()

    with closing(pool):
        assert not Scheduler(pool, store, retry=2, show=kill).run(plan.jobs())
        workers = {worker.pid for worker in active_children()}
    assert killed
    assert len(workers - set(killed)) == 2
    rows = list(store.rows())
    assert sorted(row["id"] for row in rows) == sorted(job.id for job in plan.jobs())
    assert all(row["status"] == "done" for row in rows)


def test_an_unreadable_log_gives_a_row_with_the_error(tmp_path: Path, small_log: Path) -> None:
    other = small_log.with_name("other.log")
    other.write_text(small_log.read_text())
    plan = make_plan([str(small_log), str(other)], {"modes": ["dead_reckoning"]})
    other.write_text("# nothing\n")
    small, bad = (run_job(job, str(tmp_path / "runs"), pictures=False) for job in plan.jobs())
    assert small is not None
    assert bad is not None
    assert small["command"].startswith(f"hopslam replay {small_log}")
    assert (small["status"], small["scans"], small["error_m"]) == ("done", 12, None)
    assert bad["status"] == "failed"
    assert "other.log" in bad["error"]
    assert [path.name for path in (tmp_path / "runs").iterdir()] == [small["id"]]


@pytest.mark.parametrize(("metric", "worst"), [("ate_rmse_m", "3"), ("wall_recall", "1"), ("wall.own", "3")])
def test_the_worst_run_follows_the_direction_of_the_metric(metric: str, worst: str) -> None:
    group = RunGroup("room", "hopslam", {}, seeds=[4, 5, 6], values=[1.0, 3.0, 2.0], runs=3)
    group.commands = [(f"id{seed}", "hopslam run") for seed in group.seeds]
    assert tables([group], metric)[0].rows[0][-1] == worst
    assert worst_runs([group], metric)[0].reason == f"{metric} {worst}"
