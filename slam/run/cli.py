"""The command line: ``hopslam``."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable
from types import FrameType
from typing import Annotated, NoReturn

import typer

from slam.errors import HopslamError
from slam.run.commands.bench import app as bench
from slam.run.commands.calibrate import app as calibrate
from slam.run.commands.compare import compare
from slam.run.commands.devices import doctor, emulate
from slam.run.commands.env import env
from slam.run.commands.eval import evaluate
from slam.run.commands.export import export
from slam.run.commands.lines import lines
from slam.run.commands.localize import localize
from slam.run.commands.replay import replay
from slam.run.commands.report import animate, report
from slam.run.commands.run import run
from slam.run.commands.schema import schema
from slam.run.commands.sweep import app as sweep
from slam.run.commands.view import view
from slam.run.commands.world import world
from slam.run.ending_signals import ENDING_SIGNALS, handled
from slam.run.lasting_output import LastingOutput
from slam.run.suspensions import count_suspensions
from slam.run.terminal import Terminal

app = typer.Typer(
    help="A robot testbed for line-based SLAM with a cheap 2-D lidar.",
    no_args_is_help=True,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
)
_PANELS: dict[str, dict[str, Callable[..., None]]] = {
    "Run": {"run": run, "replay": replay, "localize": localize, "lines": lines},
    "Worlds": {"world": world, "env": env, "schema": schema},
    "Look": {"view": view, "report": report, "animate": animate},
    "Share and score": {"export": export, "eval": evaluate, "compare": compare},
    "The robot": {"doctor": doctor, "emulate": emulate},
}
for panel, commands in _PANELS.items():
    for name, command in commands.items():
        app.command(name, rich_help_panel=panel)(command)
app.add_typer(sweep, name="sweep", rich_help_panel="Run")
app.add_typer(calibrate, name="calibrate", rich_help_panel="The robot")
app.add_typer(bench, name="bench", rich_help_panel="Measure")
console = Terminal()


def _show_version(asked: bool) -> None:
    if asked:
        from importlib.metadata import version

        console.print(f"hopslam {version('hopslam')}")
        raise typer.Exit


@app.callback()
def _hopslam(
    version: Annotated[bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Show it.")] = False,
) -> None:
    """A robot testbed for line-based SLAM with a cheap 2-D lidar."""


def _exit_code() -> int:
    """Run the command; known errors are one line."""
    received: list[int] = []

    def interrupt(number: int, _: FrameType | None) -> NoReturn:
        received.append(number)
        raise KeyboardInterrupt

    try:
        with handled(interrupt, set(ENDING_SIGNALS) - {signal.SIGINT}):
            app()
    except HopslamError as error:
        print(f"hopslam: {error}", file=sys.stderr)
        return error.exit_code
    except KeyboardInterrupt:
        return 128 + (received or [signal.SIGINT])[0]
    except SystemExit as leave:
        code = int(leave.code or 0)
        return 128 + received[0] if received and code == 130 else code  # typer makes 130 of every KeyboardInterrupt
    return 0


def main() -> None:
    """Run the command line.

    Exit codes: 2 bad input, 3 a device or back end, 1 or 141 output that cannot be written, 130 Ctrl-C, and 128 + N for
    the signal N.
    """
    output = LastingOutput()
    count_suspensions()  # also those before there is a robot
    raise SystemExit(_exit_code() or output.exit_code())
