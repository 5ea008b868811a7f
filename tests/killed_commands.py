"""Commands in processes of their own, which are killed, and what other processes see of them, for tests."""

import os
import signal
import sys
import time
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO, NamedTuple

from mcap.exceptions import McapError
from mcap.records import Channel, Message
from mcap.stream_reader import StreamReader

from slam.cli.main import main
from slam.run.results.run_log import RunLog
from slam.run.step import Step


class Started(NamedTuple):
    """A command that runs."""

    child: int
    """Number of its process."""
    witness: IO[bytes]
    """File with the stamps of the scans that it saw, a line each; a pipe would be full after some thousand of them."""


def start(words: list[str]) -> Started:
    """Run a command in a child process, which has imported all that it needs."""
    witness = TemporaryFile(buffering=0)  # noqa: SIM115  used by both processes
    if child := os.fork():
        return Started(child, witness)
    code = 1
    try:
        nowhere = os.open(os.devnull, os.O_RDWR)
        for stream in (1, 2):
            os.dup2(nowhere, stream)
        record_stamps(witness.fileno())
        sys.argv = ["hopslam", *words]
        main()
    except SystemExit as left:
        code = int(left.code or 0)
    finally:
        os._exit(code)


def record_stamps(witness: int) -> None:
    """Write the stamp of each scan of this process to ``witness`` before the scan is recorded."""
    on_step = RunLog.on_step

    def recording(log: RunLog, step: Step) -> None:
        os.write(witness, b"%.6f\n" % step.observation.scan.stamp)
        on_step(log, step)

    RunLog.on_step = recording  # type: ignore[method-assign,assignment]  # of this process alone


def end(started: Started, seconds: float, begun: Path | None = None) -> list[float]:
    """Kill the command ``seconds`` after it began or wrote the file ``begun``; return the stamps of its scans."""
    until = time.monotonic() + 120.0
    while begun is not None and not begun.is_file() and time.monotonic() < until and is_running(started.child):
        time.sleep(0.001)
    time.sleep(seconds)
    os.kill(started.child, signal.SIGKILL)
    os.waitpid(started.child, 0)
    with started.witness as stamps:
        stamps.seek(0)
        return [float(line) for line in stamps if line.endswith(b"\n")]


def is_running(child: int) -> bool:
    """Return True while the process runs; a zombie has ended."""
    return os.waitid(os.P_PID, child, os.WEXITED | os.WNOHANG | os.WNOWAIT) is None


def result_of(started: Started) -> int:
    """Exit code of a command that comes to its end."""
    code = os.waitstatus_to_exitcode(os.waitpid(started.child, 0)[1])
    started.witness.close()
    return code


def children_of(process: int) -> list[int]:
    """Numbers of the processes that this one has started."""
    return [int(word) for word in Path(f"/proc/{process}/task/{process}/children").read_text().split()]


def logged_stamps(path: Path) -> list[float]:
    """Return the times of the scans in a log that may be truncated, read by the format's own reference library."""
    stamps, scans = list[float](), set[int]()
    if not path.is_file():
        return []
    with path.open("rb") as file, suppress(McapError):
        for record in StreamReader(file).records:
            if isinstance(record, Channel) and record.topic == "/scan":
                scans.add(record.id)
            elif isinstance(record, Message) and record.channel_id in scans:
                stamps.append(record.log_time / 1e9)
    return stamps
