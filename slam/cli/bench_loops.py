"""``hopslam bench loops``."""

from pathlib import Path
from typing import Annotated

import typer

from slam.cli.bench import TablesFile, console, print_tables, use_one_thread
from slam.console.options import Settings
from slam.errors import InputError


def bench_loops(
    parts: Annotated[
        list[str] | None,
        typer.Argument(metavar="[PART]...", help="logs, sim, blocks, stress, hour; default: the first three."),
    ] = None,
    logs: Annotated[
        list[str] | None,
        typer.Option("--log", metavar="NAME", help="logs, stress: only this log; may be given again."),
    ] = None,
    data: Annotated[Path, typer.Option(metavar="DIR", help="Folder of the recorded logs.")] = Path("../shared/data"),
    variants: Annotated[
        list[str] | None,
        typer.Option("--variant", metavar="NAME=X,...", help="stress: only this variant; may be given again."),
    ] = None,
    seeds: Annotated[
        int | None,
        typer.Option(
            min=0,
            help="Runs; default: 8 of aces with noise (logs), 10 of a scenario (sim), 5 of a variant (stress).",
        ),
    ] = None,
    stress: Annotated[bool, typer.Option("--stress", help="The same as the part stress.")] = False,
    hour: Annotated[bool, typer.Option("--hour", help="The same as the part hour.")] = False,
    settings: Settings = None,
    out: TablesFile = None,
) -> None:
    """Measure the benefit and the cost of loop closing, with the same settings for all runs.

    Every run is made with and without loop closing; errors are those of the poses during the run, and of the final
    poses.

    logs: recorded logs, their loops, and the cost per scan with and without loop closing. Missing logs are skipped.

    sim: office_loop and campus_loop against the truth.

    blocks: a generated building of 2 km, for time and memory; no other program should run at the same time.

    stress: harder variants of logs, see bench slam.

    hour: one simulated hour around office_loop.

    [bold]Examples[/bold]

    hopslam bench loops

    hopslam bench loops logs --log fr079 --log aces --seeds 0 --data ~/logs

    hopslam bench loops sim --seeds 3 --out /tmp/loops.md

    hopslam bench loops --stress --variant every=5,blind=10 --seeds 2

    hopslam bench loops --hour
    """
    use_one_thread()
    from slam.bench.loops_report import LoopBench, loop_tables

    asked = [*(parts or []), *["stress"] * stress, *["hour"] * hour]
    if variants and "stress" not in asked:
        raise InputError("--variant: needs --stress")
    bench = LoopBench(data, logs or [], variants or [], seeds, tuple(settings or ()), console)
    print_tables(loop_tables(asked, bench), out, "Loops")
