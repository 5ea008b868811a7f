"""The command line: ``hopslam``."""

import signal
import sys
from types import FrameType
from typing import Annotated, Final, NoReturn

import typer

from slam.cli.lazy_group import lazy_group
from slam.console.robust_output import RobustOutput
from slam.console.signals import count_suspensions, signal_handler
from slam.console.terminal import Terminal
from slam.errors import HopslamError
from slam.system import ENDING_SIGNALS

COMMANDS: Final = {
    "Run": {
        "run": "slam.cli.run:run",
        "replay": "slam.cli.replay:replay",
        "localize": "slam.cli.localize:localize",
        "repair": "slam.cli.repair:repair",
        "optimize": "slam.cli.optimize:optimize",
        "lines": "slam.cli.lines:lines",
        "sweep": "slam.cli.sweep:app",
    },
    "Worlds": {"world": "slam.cli.world:world", "env": "slam.cli.env:env", "schema": "slam.cli.world:schema"},
    "Look": {"view": "slam.cli.view:view", "report": "slam.cli.report:report", "animate": "slam.cli.report:animate"},
    "Share and score": {
        "export": "slam.cli.export:export",
        "eval": "slam.cli.eval:evaluate",
        "compare": "slam.cli.compare:compare",
    },
    "The robot": {
        "doctor": "hardware.cli.doctor:doctor",
        "emulate": "hardware.cli.emulate:emulate",
        "wire": "hardware.cli.wire:wire",
        "calibrate": "slam.cli.calibrate:app",
        "ros": "slam.cli.ros:app",
    },
    "Measure": {"bench": "slam.cli.bench:app"},
    "About": {"licences": "slam.cli.licences:licences"},
}
"""Every command by its panel in ``hopslam --help``, with the place of its function or app."""
app = typer.Typer(
    cls=lazy_group(
        {name: place for commands in COMMANDS.values() for name, place in commands.items()},
        {name: panel for panel, commands in COMMANDS.items() for name in commands},
    ),
    no_args_is_help=True,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
)
console = Terminal()


def _show_version(asked: bool) -> None:
    if asked:
        from importlib.metadata import version

        console.print(f"hopslam {version('hopslam')}")
        raise typer.Exit


@app.callback()
def _hopslam(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    """A robot testbed for line-based SLAM with a cheap 2-D lidar."""


def _exit_code() -> int:
    """Run the command; print known errors as one line, and return the exit code."""
    received: list[int] = []

    def interrupt(number: int, _: FrameType | None) -> NoReturn:
        received.append(number)
        raise KeyboardInterrupt

    try:
        with signal_handler(interrupt, set(ENDING_SIGNALS) - {signal.SIGINT}):
            app()
    except HopslamError as error:
        print(f"hopslam: {error}", file=sys.stderr)
        return error.exit_code
    except KeyboardInterrupt:
        return 128 + (received or [signal.SIGINT])[0]
    except RuntimeError as error:
        if not isinstance(error.__cause__, KeyboardInterrupt):
            raise
        return 128 + (received or [signal.SIGINT])[0]  # CPython 3.11 raises RuntimeError for Ctrl-C in a class body
    except SystemExit as leave:
        code = int(leave.code or 0)
        return 128 + received[0] if received and code == 130 else code  # typer gives 130 for all
    return 0


def main() -> None:
    """Run the command line.

    Exit codes: 2 bad input, 3 a device or back end, 4 a log most of which could not be used, 1 or 141 output that
    cannot be written, 130 Ctrl-C, and 128 + N for the signal N.
    """
    output = RobustOutput()
    count_suspensions()  # including suspensions before there is a robot
    raise SystemExit(_exit_code() or output.exit_code())
