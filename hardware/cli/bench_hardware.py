"""``hopslam bench hardware``."""

from collections.abc import Callable
from enum import StrEnum
from typing import Annotated

import typer

from slam.console.options import AllowModules


class Benchmark(StrEnum):
    """The benchmarks, one table each."""

    LOAD = "load"
    FAULTS = "faults"
    ENDINGS = "endings"
    NOISE = "noise"
    SIM = "sim"
    ENV = "env"


def bench_hardware(
    parts: Annotated[list[Benchmark] | None, typer.Argument(help="Benchmarks; default: all.")] = None,
    seconds: Annotated[float, typer.Option(min=2.0, metavar="S", help="load: seconds to drive.")] = 20.0,
    packets: Annotated[int, typer.Option(min=1, help="noise: messages of each kind.")] = 10_000,
    scenario: Annotated[str, typer.Option(metavar="NAME", help="sim, env: scenario to drive.")] = "corridor",
    settings: Annotated[
        list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="load, faults, sim, env: change one setting.")
    ] = None,
    allow_modules: AllowModules = None,
) -> None:
    """Measure the drivers on emulated devices.

    load: processor time, and delay of scans. faults: time until the robot stops after a fault, and until it moves
    again. endings: time until it stops when its program is ended, suspended, or loses its terminal or its disk. noise:
    messages received in spite of damaged bytes. sim: the same scenario driven by the simulated robot and by the
    drivers, in real time, with noise and without. env: one policy in the learning environment, simulated and on
    devices, to x = 10 m. All parts together take about fifteen minutes; an idle machine gives better numbers.

    [bold]Examples[/bold]

    hopslam bench hardware

    hopslam bench hardware load faults --seconds 60

    hopslam bench hardware load faults sim --set lidar.model=ld19

    hopslam bench hardware endings

    hopslam bench hardware sim --set seed=3

    hopslam bench hardware sim --scenario office_loop

    hopslam bench hardware env --set seed=3
    """
    import os
    import sys

    from slam.console.result_table import ResultTable
    from slam.console.terminal import Terminal
    from slam.errors import InputError

    if sys.platform != "linux":
        raise InputError("hopslam bench hardware needs functions that only Linux has; run it on Linux")
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    console = Terminal()
    from hardware.bench import report

    tables: dict[Benchmark, Callable[[], ResultTable]] = {
        Benchmark.FAULTS: lambda: report.fault_table(console, settings or []),
        Benchmark.ENDINGS: lambda: report.ending_table(console),
        Benchmark.LOAD: lambda: report.load_table(seconds, console, settings or []),
        Benchmark.NOISE: lambda: report.noise_table(packets, console),
        Benchmark.SIM: lambda: report.sim_table(scenario, settings or [], console, allow_modules or []),
        Benchmark.ENV: lambda: report.env_table(scenario, settings or [], allow_modules or []),
    }
    for benchmark, table in tables.items():
        if not parts or benchmark in parts:
            console.print(table().for_terminal())
