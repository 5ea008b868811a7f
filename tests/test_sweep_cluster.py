"""Sweeps on a Ray cluster of two nodes on one machine, parts of which are killed. Minutes: HOPSLAM_CLUSTER_TESTS=1."""

import os
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from slam.run.sweep.folder import Folder
from slam.run.sweep.options import make_plan
from slam.run.sweep.store import SweepStore

pytestmark = pytest.mark.skipif(
    "HOPSLAM_CLUSTER_TESTS" not in os.environ, reason="takes minutes; set HOPSLAM_CLUSTER_TESTS=1 to run them"
)
RUNS = 200
PORT = 46379
WORDS = ["paper_simulation", "--mode", "dead_reckoning", "--set", "duration=4", "--seeds", f"0:{RUNS}"]
ENVIRONMENT = os.environ | {"PYTHONPATH": str(Path(__file__).parents[1]), "RAY_USAGE_STATS_ENABLED": "0"}


class TwoNodes:
    """Each node is a raylet with one processor; the head has the other processes of the cluster too."""

    def __init__(self, temporary: Path) -> None:
        self._temporary = temporary
        self._start("--head", f"--port={PORT}", "--include-dashboard=false", f"--temp-dir={temporary}")
        self.head = self.raylets()
        self.add()

    def add(self) -> None:
        """Another node."""
        self._start(f"--address=127.0.0.1:{PORT}")

    def raylets(self) -> set[int]:
        return self._processes("raylet/raylet ")

    def workers(self) -> set[int]:
        """Those that run a task now."""
        return self._processes("ray::run_on_cluster")

    def stop(self) -> None:
        """All processes of this cluster, which all name its folder or stand under its raylets."""
        for pid in self.raylets() | self._processes(str(self._temporary)) | self._processes(f"127.0.0.1:{PORT}"):
            if pid != os.getpid():
                kill(pid)

    def _start(self, *words: str) -> None:
        command = [sys.executable, "-m", "ray.scripts.scripts", "start", "--num-cpus=1", "--node-ip-address=127.0.0.1"]
        subprocess.run([*command, *words], env=ENVIRONMENT, check=True, capture_output=True)

    def _processes(self, text: str) -> set[int]:
        """Ids of the processes with this in their command line, and of this cluster's session."""
        found = set()
        for path in Path("/proc").glob("[0-9]*/cmdline"):
            try:
                line = path.read_bytes().replace(b"\0", b" ").decode(errors="replace")
            except OSError:
                continue
            if text in line and "pytest" not in line:
                found.add(int(path.parent.name))
        return found


def kill(pid: int) -> None:
    try:
        os.kill(pid, signal.SIGKILL)
    except ProcessLookupError:
        pass


@pytest.fixture
def cluster() -> Iterator[TwoNodes]:
    """Two nodes; short paths, because Ray's sockets lie in its folder."""
    folder = Path(f"/tmp/hopslam-ray-{os.getpid()}")
    nodes = TwoNodes(folder)
    yield nodes
    nodes.stop()


def start_driver(out: Path) -> subprocess.Popen[bytes]:
    command = "from slam.run.cli import main; main()"
    words = ["sweep", *WORDS, "--ray", f"127.0.0.1:{PORT}", "--retry", "5", "--out", str(out)]
    with (out.parent / "driver.txt").open("ab") as said:
        return subprocess.Popen([sys.executable, "-c", command, *words], env=ENVIRONMENT, stdout=said, stderr=said)


def rows_of(out: Path) -> list[str]:
    """Ids of the rows that are there, in the results and in the journal."""
    compacted = [row["id"] for row in SweepStore(Folder(str(out))).rows(["id"])]
    return compacted + [path.stem for path in (out / "rows").glob("*.json")]


def wait_for(condition: Callable[[], bool], driver: subprocess.Popen[bytes], seconds: float = 300) -> None:
    until = time.monotonic() + seconds
    while not condition():
        assert driver.poll() is None, "the driver ended"
        assert time.monotonic() < until
        time.sleep(0.2)


def test_all_rows_are_there_once_though_worker_node_and_driver_are_killed(cluster: TwoNodes, tmp_path: Path) -> None:
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
    before = len(set(rows_of(out)))
    assert 80 < before < RUNS
    again = start_driver(out)
    assert again.wait(timeout=500) == 0, (out.parent / "driver.txt").read_text()
    said = (out.parent / "driver.txt").read_text()
    assert f"{RUNS - before} runs done, 0 of them failed; {before} were there already" in " ".join(said.split())
    kept = Counter(row["id"] for row in SweepStore(Folder(str(out))).rows())
    planned = make_plan(["paper_simulation"], {
        "modes": ["dead_reckoning"], "settings": {"duration": 4}, "seeds": f"0:{RUNS}"
    })  # fmt: skip
    assert kept == Counter(job.id for job in planned.jobs())
    assert all(row["status"] == "done" for row in SweepStore(Folder(str(out))).rows())
