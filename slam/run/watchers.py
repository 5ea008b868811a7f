"""Watchers that write no file: the progress bar of a run, and the signals that end it."""

from contextlib import ExitStack
from signal import SIGINT
from time import perf_counter
from types import FrameType

from slam.closing import Closing
from slam.console.signals import signal_handler
from slam.console.terminal import Terminal
from slam.pose import Pose2D
from slam.run.step import Step
from slam.system import ENDING_SIGNALS


class RunProgress(Closing):
    """Watcher that shows the progress of the run, its scan rate, and its present error if the true pose is known."""

    def __init__(self, console: Terminal, name: str) -> None:
        self._bar = console.progress(
            "{task.percentage:>3.0f}%", "{task.fields[scans]} scans", "{task.fields[rate]}", "{task.fields[error]}"
        )
        self._task = self._bar.add_task(name, total=1.0, scans=0, rate="", error="")
        self._began = perf_counter()
        self._bar.start()

    def on_step(self, step: Step) -> None:
        """Show one step."""
        scans = step.index + 1
        rate = f"{scans / max(perf_counter() - self._began, 1e-9):.0f}/s"
        self._bar.update(self._task, completed=step.progress, scans=scans, rate=rate, error=_error(step))

    def close(self) -> None:
        """Remove the bar."""
        self._bar.stop()


def _error(step: Step) -> str:
    truth = step.observation.T_map_base
    if truth is None:
        return ""
    error: Pose2D = truth.between(step.estimate.T_map_base)
    return f"error {100 * error.distance(Pose2D()):.1f} cm"


class Interruption(Closing):
    """Watcher that ends the run after the step in which the user asked for it, so that no step is left half done.

    Elsewhere a KeyboardInterrupt could occur inside compiled code, which turns it into a SystemError. The work after
    the loop is completed, unless Ctrl-C is pressed again. A closed terminal does not end a program that was started
    with nohup.
    """

    def __init__(self) -> None:
        self.signal: int | None = None
        """Number of the first signal; None before one."""
        self._handlers = ExitStack()
        self._handlers.enter_context(signal_handler(self._ask, ENDING_SIGNALS))

    def asked(self) -> bool:
        """Return True if the user asked for the end."""
        return self.signal is not None

    def close(self) -> None:
        """Restore the signal handlers."""
        self._handlers.close()

    def on_step(self, step: Step) -> None:
        """Raise KeyboardInterrupt if the user asked for the end."""
        if self.signal is not None:
            raise KeyboardInterrupt

    def _ask(self, number: int, frame: FrameType | None) -> None:
        if self.signal is None:
            self.signal = number
        elif number == SIGINT:
            raise KeyboardInterrupt
