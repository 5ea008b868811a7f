"""Sweeps on a Ray cluster of two nodes on one machine whose processes are killed: HOPSLAM_CLUSTER_TESTS=1."""

import os
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from slam.sweep.folder import Folder
from slam.sweep.make_plan import make_plan
from slam.sweep.result_store import ResultStore

pytestmark = pytest.mark.skipif(
    "HOPSLAM_CLUSTER_TESTS" not in os.environ, reason="takes minutes; set HOPSLAM_CLUSTER_TESTS=1 to run them"
)
RUNS = 200
"""Number of runs; each is short, so that many end between two kills."""
PORT = 46379
WORDS = ["paper_simulation", "--mode", "dead_reckoning", "--set", "duration=4", "--seeds", f"0:{RUNS}"]
ENVIRONMENT = os.environ | {
    "PYTHONPATH": str(Path(__file__).parents[1]),
    "RAY_USAGE_STATS_ENABLED": "0",
    "RAY_AUTH_MODE": "disabled",  # all of it is on the loopback
}


class TwoNodes:
    """Each node is a raylet with one processor; the head has the other processes of the cluster too."""

    def __init__(self, temporary: Path) -> None:
        self._temporary = temporary
        self.head: set[int] = set()

    def start(self) -> None:
        """Start both nodes."""
        temporary = self._temporary
        self._start("--head", f"--port={PORT}", "--include-dashboard=false", f"--temp-dir={temporary}")
        self.head = self.raylets()
        self.add()

    def add(self) -> None:
        """Start another node."""
        self._start(f"--address=127.0.0.1:{PORT}")

    def raylets(self) -> set[int]:
        """Return the ids of the raylets, one for each node; they have the cluster's folder in their command line."""
        return {pid for pid in self._processes(str(self._temporary)) if "raylet/raylet " in line_of(pid)}

    def workers(self) -> set[int]:
        """Return the processes that run a task now: children of these raylets."""
        return {pid for pid in self._processes("ray::run_on_cluster") if parent_of(pid) in self.raylets()}

    def stop(self) -> None:
        """Kill all processes with the cluster's folder in their command line; their children end with them."""
        for pid in self._processes(str(self._temporary)):
            kill(pid)

    def _start(self, *words: str) -> None:
        command = [sys.executable, "-m", "ray.scripts.scripts", "start", "--num-cpus=1", "--node-ip-address=127.0.0.1"]
        subprocess.run([*command, *words], env=ENVIRONMENT, check=True, capture_output=True)

    def _processes(self, text: str) -> set[int]:
        """Ids of the processes with this in their command line."""
        everyone = [int(path.name) for path in Path("/proc").glob("[0-9]*")]
        return {pid for pid in everyone if pid != os.getpid() and text in line_of(pid)}


def line_of(pid: int) -> str:
    """The command line of a process; empty for one that is gone."""
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
    except OSError:
        return ""


def parent_of(pid: int) -> int:
    """0 for a process that is gone."""
    try:
        return int(Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[1])
    except OSError:
        return 0


def kill(pid: int) -> None:
    with suppress(ProcessLookupError):
        os.kill(pid, signal.SIGKILL)


@pytest.fixture
def cluster() -> Iterator[TwoNodes]:
    """Two nodes; short paths, because Ray's sockets lie in its folder."""
    folder = Path(f"/tmp/hopslam-ray-{os.getpid()}")
    nodes = TwoNodes(folder)
    try:
        nodes.start()
        yield nodes
    finally:
        nodes.stop()
        shutil.rmtree(folder, ignore_errors=True)


def start_driver(out: Path) -> subprocess.Popen[bytes]:
    command = "from slam.cli.main import main; main()"
    words = ["sweep", *WORDS, "--ray", f"127.0.0.1:{PORT}", "--retry", "5", "--out", str(out)]
    with (out.parent / "driver.txt").open("ab") as said:
        return subprocess.Popen([sys.executable, "-c", command, *words], env=ENVIRONMENT, stdout=said, stderr=said)


def rows_of(out: Path) -> list[str]:
    """Ids of the rows that are there, in the results and in the journal."""
    compacted = [row["id"] for row in ResultStore(Folder(str(out))).rows(["id"])]
    return compacted + [path.stem for path in (out / "rows").glob("*.json")]


def wait_for(condition: Callable[[], bool], driver: subprocess.Popen[bytes], seconds: float = 300) -> None:
    until = time.monotonic() + seconds
    while not condition():
        assert driver.poll() is None, "the driver ended"
        assert time.monotonic() < until
        time.sleep(0.2)


def test_after_kills_each_row_exists_once(cluster: TwoNodes, tmp_path: Path) -> None:
    out = tmp_path / "out"
    driver = start_driver(out)
    wait_for(lambda: len(rows_of(out)) > 20 and bool(cluster.workers()), driver)
    kill(next(iter(cluster.workers())))
    seen = len(rows_of(out))
    wait_for(lambda: len(rows_of(out)) > seen + 20, driver)
    kill(next(iter(cluster.raylets() - cluster.head)))
    seen = len(rows_of(out))
    wait_for(lambda: len(rows_of(out)) > seen + 20, driver)
    cluster.add()
    seen = len(rows_of(out))
    wait_for(lambda: len(rows_of(out)) > seen + 20, driver)
    driver.kill()
    driver.wait()
    store = ResultStore(Folder(str(out)))
    store.compact()
    assert [row["error"] for row in store.rows() if row["status"] != "done"] == []
    before = len(store.done())
    assert 80 < before < RUNS
    again = start_driver(out)
    assert again.wait(timeout=500) == 0, (out.parent / "driver.txt").read_text()
    said = (out.parent / "driver.txt").read_text()
    assert f"{RUNS - before} runs done, 0 of them failed; {before} were there already" in " ".join(said.split())
    kept = Counter(row["id"] for row in ResultStore(Folder(str(out))).rows())
    planned = make_plan(["paper_simulation"], {
        "modes": ["dead_reckoning"], "settings": {"duration": 4}, "seeds": f"0:{RUNS}"
    })  # fmt: skip
    assert kept == Counter(job.id for job in planned.jobs())
    assert all(row["status"] == "done" for row in ResultStore(Folder(str(out))).rows())
