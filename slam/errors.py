"""Every error that hopslam raises on purpose.

HopslamError
├── InputError          the user's input cannot be used            (exit code 2)
│   ├── ScenarioError   a scenario, a setting or a ``--set``
│   └── LogError        a recorded log
│       └── ScansLost   most of its scans could not be used    (exit code 4)
├── RobotError          a device or back end failed                (exit code 3)
│   ├── RobotTimeout    no data within the time asked for
│   ├── BatteryEmpty    the battery of a real robot is at its end
│   └── OutputLost      nobody watches a real robot any more   (exit code 141)
├── StorageError        results cannot be written any more         (exit code 3)
├── BackEndLost         the process that closes loops has ended    (exit code 3)
└── ClusterError        the machines that run the jobs cannot      (exit code 3)
"""

from collections.abc import Iterable
from difflib import get_close_matches


class HopslamError(Exception):
    """Base of all errors of this project; its message is one line that says what to do next."""

    exit_code = 1


class InputError(HopslamError):
    """The user's input cannot be used."""

    exit_code = 2


class ScenarioError(InputError):
    """A scenario file, or a setting given on the command line, is wrong."""


class LogError(InputError):
    """A recorded log cannot be read."""


class ScansLost(LogError):
    """Most scans of a recorded log could not be used; the results of the others are written."""

    exit_code = 4


class RobotError(HopslamError):
    """A device or a back end failed."""

    exit_code = 3


class RobotTimeout(RobotError, TimeoutError):
    """No data arrived within the timeout."""


class BatteryEmpty(RobotError):
    """The battery is empty, and the robot was stopped."""


class OutputLost(RobotError):
    """The terminal is closed, or the reader of the output has ended; a real robot stops then."""

    exit_code = 141  # 128 + SIGPIPE


class StorageError(HopslamError):
    """Results cannot be written any more: the disk is full, or the folder is gone."""

    exit_code = 3


class BackEndLost(HopslamError):
    """The process that closes loops ended too early."""

    exit_code = 3


class ClusterError(HopslamError):
    """The machines of a sweep were lost, or cannot run its jobs."""

    exit_code = 3


def did_you_mean(word: str, known: Iterable[str], otherwise: str | None = None) -> str:
    """Suggest the known word that is most similar; else return ``otherwise``, or list all known words."""
    known = list(known)
    if close := get_close_matches(word, known, n=1):
        return f"did you mean {close[0]}?"
    return f"known here: {', '.join(known)}" if otherwise is None else otherwise


def shown(value: object) -> str:
    """Shorten the text of a value to one line of a few characters."""
    text = " ".join(repr(value).split())
    return text if len(text) <= 40 else f"{text[:37]}..."
