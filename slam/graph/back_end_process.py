"""The back end in a separate process, so that its search does not delay the loop of the robot.

Key scans go in by its standard input, closures come out by its standard output, both in order. Two threads move them,
so that neither side waits for the other. The back end ends at the end of its input, which comes even if its parent is
killed. It ignores signals that end a program: the loop handles them, and then asks for the last result.
"""

import os
import pickle
import signal
import subprocess
import sys
import weakref
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from queue import Empty, SimpleQueue
from threading import Thread
from typing import IO, Any, Final

from slam.config import LeastSquaresConfig, SurfelMapConfig
from slam.errors import BackEndLost
from slam.graph.back_end import BackEnd
from slam.graph.closure import ClosedRun, Closure
from slam.graph.graph_size import GraphSize
from slam.graph.key_scan import KeyScan
from slam.graph.known_graph import KnownGraph
from slam.pose import FloatArray
from slam.system import ENDING_SIGNALS, reader_has_ended

_END = None
LEAN_HEAP: Final = {"MALLOC_ARENA_MAX": "1", "MALLOC_MMAP_THRESHOLD_": "1048576", "MALLOC_TRIM_THRESHOLD_": "1048576"}
"""Makes glibc return arrays of a megabyte and more to the system at once; it has no effect on results."""


class BackEndProcess:
    """A process that takes key scans, and returns a result for each submap that they finish.

    BackEndLost if the process cannot be started, and if it has ended before a requested result.
    """

    def __init__(
        self,
        matching: LeastSquaresConfig,
        config: SurfelMapConfig,
        keys: Iterable[KeyScan],
        known: KnownGraph | None = None,
    ) -> None:
        self._out: SimpleQueue[Any] = SimpleQueue()
        self._in: SimpleQueue[Any] = SimpleQueue()
        command = [sys.executable, "-m", "slam.graph.back_end_process"]
        environment = LEAN_HEAP | os.environ
        try:
            process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment)
        except OSError as error:
            raise BackEndLost(f"the process that closes loops cannot be started: {error.strerror}") from error
        sender = Thread(target=_send, args=(self._out, process), name="to the back end", daemon=True)
        receiver = Thread(target=_receive, args=(process, self._in), name="from the back end", daemon=True)
        self.size = GraphSize()
        """Size of the graph at the last result."""
        self._finalizer = weakref.finalize(self, _end, self._out, process, (sender, receiver))
        sender.start()
        receiver.start()
        self._out.put((matching, config, known))
        for key in keys:
            self._out.put(key)

    def send(self, key: KeyScan) -> None:
        """Send the next key scan to the process; returns at once."""
        self._out.put(key)

    def next_result(self, wait: bool) -> tuple[bool, Closure | None]:
        """Return True and the closure, if any, for the next finished submap.

        False and None if it is not known yet, which is impossible with ``wait``.
        """
        try:
            closure, self.size = self._received(wait)
        except Empty:
            return False, None
        return True, closure

    def finish(self, T_base_laser: FloatArray) -> ClosedRun:
        """Return the whole run, refined, after the last key scan.

        Earlier results that were not requested are dropped.
        """
        self._out.put(T_base_laser)
        while not isinstance(result := self._received(wait=True), ClosedRun):
            pass
        self._in.get()  # the process ends by itself after its last result
        self._finalizer()
        return result

    def _received(self, wait: bool) -> Any:
        result = self._in.get(block=wait)
        if isinstance(result, _Ended):
            self._in.put(result)  # the next call raises it again
            self._finalizer()
            raise BackEndLost(f"the process that closes loops {result.how}")
        return result


@dataclass(frozen=True, slots=True)
class _Ended:
    """The process has ended, and returns no more results."""

    code: int
    """Exit code; less than zero after a signal."""

    @property
    def how(self) -> str:
        """Describe the exit, as in ``was killed by SIGKILL; is the memory full?``."""
        if self.code >= 0:
            return f"ended with exit code {self.code}"
        name = signal.Signals(-self.code).name
        return f"was killed by {name}" + ("; is the memory full?" if name == "SIGKILL" else "")


def _send(queue: "SimpleQueue[Any]", process: "subprocess.Popen[bytes]") -> None:
    stream = _stream(process.stdin)
    with suppress(OSError), stream:  # the process may have ended
        while (message := queue.get()) is not _END:
            pickle.dump(message, stream, pickle.HIGHEST_PROTOCOL)
            stream.flush()


def _receive(process: "subprocess.Popen[bytes]", queue: "SimpleQueue[Any]") -> None:
    stream = _stream(process.stdout)
    with suppress(EOFError, OSError, pickle.UnpicklingError), stream:
        while True:
            queue.put(pickle.load(stream))
    queue.put(_Ended(process.wait()))


def _stream(stream: IO[bytes] | None) -> IO[bytes]:
    assert stream is not None
    return stream


def _end(queue: "SimpleQueue[Any]", process: "subprocess.Popen[bytes]", threads: tuple[Thread, ...]) -> None:
    """End the process and its threads, without waiting for results."""
    queue.put(_END)
    process.kill()
    for thread in threads:
        thread.join()


def main() -> None:
    """Run the process: take key scans until there are no more."""
    for number in ENDING_SIGNALS:  # they may be sent to a whole group of processes
        signal.signal(number, signal.SIG_IGN)
    messages, results = sys.stdin.buffer, os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # text printed by other code must not be read as a result
    try:
        _serve(messages, results)
    except EOFError:
        return
    except OSError as error:
        if not reader_has_ended(error):
            raise


def _serve(messages: IO[bytes], results: IO[bytes]) -> None:
    back_end = BackEnd(*pickle.load(messages))
    while True:
        message = pickle.load(messages)
        if not isinstance(message, KeyScan):
            pickle.dump(back_end.finish(message), results, pickle.HIGHEST_PROTOCOL)
            results.flush()
            os._exit(0)  # at once: nothing is left that must be tidied up
        finishes, closure = back_end.finishes(message), back_end.take(message)
        if finishes:
            pickle.dump((closure, back_end.size), results, pickle.HIGHEST_PROTOCOL)
            results.flush()


if __name__ == "__main__":
    main()
