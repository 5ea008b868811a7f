"""The processes of a benchmark end with it, together with the processes that their jobs started."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

JOBS = """
import os, subprocess, sys, time
from slam.errors import InputError

def hold(job):
    # the child holds the standard output open, so that the test reads its end only after the child has ended
    subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"])
    print("held", flush=True)
    time.sleep(600)

def fail(job):
    if job:
        raise InputError("job 1 is wrong")
    hold(job)

def add_one(job):
    return job + 1
"""
PROGRAM = """
import sys
import jobs, slam.cli.main as cli
from slam.bench.worker_pool import run_in_workers
from slam.console.terminal import Terminal

cli.app = lambda: print(run_in_workers(getattr(jobs, sys.argv[1]), [(0,), (1,), (2,)], "", Terminal(quiet=True)))
cli.main()
"""


def hear_ctrl_c() -> None:
    """Enable SIGINT in a child whose parent ignores it, as a shell does for background jobs."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


def start(folder: Path, job: str) -> "subprocess.Popen[str]":
    """A program, in a process group of its own, that has three jobs done by two workers."""
    (folder / "jobs.py").write_text(JOBS)
    path = os.pathsep.join([str(folder), str(Path(__file__).parent.parent)])
    return subprocess.Popen(
        [sys.executable, "-c", PROGRAM, job], env={**os.environ, "PYTHONPATH": path}, stdout=subprocess.PIPE,
        stderr=subprocess.PIPE, text=True, process_group=0, preexec_fn=hear_ctrl_c,
    )  # fmt: skip


@pytest.mark.parametrize(("name", "code"), [("SIGTERM", 143), ("SIGINT", 130), ("SIGKILL", -signal.SIGKILL)])
def test_a_signal_ends_a_pool_with_all_its_processes(tmp_path: Path, name: str, code: int) -> None:
    program = start(tmp_path, "hold")
    assert program.stdout is not None
    assert [program.stdout.readline() for _ in range(2)] == ["held\n"] * 2
    os.killpg(program.pid, getattr(signal, name))  # to the group, as a terminal does
    out, err = program.communicate(timeout=120)
    assert (program.returncode, out, err) == (code, "", "")


def test_a_job_that_fails_ends_the_other_jobs_of_its_pool(tmp_path: Path) -> None:
    program = start(tmp_path, "fail")
    _, err = program.communicate(timeout=120)
    assert (program.returncode, err) == (2, "hopslam: job 1 is wrong\n")


def test_results_are_in_the_order_of_the_jobs(tmp_path: Path) -> None:
    program = start(tmp_path, "add_one")
    assert (*program.communicate(timeout=120), program.returncode) == ("[1, 2, 3]\n", "", 0)
