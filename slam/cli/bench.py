"""``hopslam bench``: measurements."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated, Final

import typer

from slam.cli.lazy_group import lazy_group
from slam.console.options import AllowModules, ScenarioName, Settings, complete_scenario
from slam.console.terminal import Terminal

BENCHES: Final = {
    "paper": "slam.cli.bench:paper",
    "lines": "slam.cli.bench:lines",
    "slam": "slam.cli.bench:slam",
    "localize": "slam.cli.bench:localize",
    "match": "slam.cli.bench:match",
    "sweep": "slam.cli.bench:sweep",
    "slam-sim": "slam.cli.bench:slam_sim",
    "viewer": "slam.cli.bench:viewer",
    "start": "slam.cli.bench:start",
    "sim": "sim.cli.bench_sim:bench_sim",
    "hardware": "hardware.cli.bench_hardware:bench_hardware",
}
"""Every subcommand, with the place of its function."""
app = typer.Typer(cls=lazy_group(BENCHES), no_args_is_help=True, add_completion=False)
console = Terminal()


@app.callback()
def _bench() -> None:
    """Measure the paper's figures, extractors, matchers, localisation, SLAM, simulator, drivers, sweeps, start-up."""


def paper(
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the report and the pictures.")] = Path(
        "bench/paper"
    ),
    quick: Annotated[bool, typer.Option("--quick", help="Fewer points and trials: seconds, not minutes.")] = False,
) -> None:
    """Measure Table 2 and Figs. 7, 8 and 10 of the paper again, beside its own numbers.

    The whole of Table 2 takes some minutes, nearly all of it for the full U that the paper's SVD has.

    [bold]Examples[/bold]

    hopslam bench paper --quick

    hopslam bench paper --out /tmp/paper
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # numpy reads it when it is imported; threads wait for others
    from slam.bench.paper.report import reproduce

    report = reproduce(out, quick, console)
    for table in report.tables:
        console.print(table.for_terminal())
    console.print(f"report and pictures in {report.path.parent}")


def lines(
    log: Annotated[
        Path | None, typer.Option(metavar="FILE", help="A recorded log, instead of simulated scans.")
    ] = None,
    seeds: Annotated[int, typer.Option(min=1, max=60, help="Seeds of each family of floor plan.")] = 60,
    sensor: Annotated[
        str | None, typer.Option(metavar="NAME", help="With --log: whose noise ours expects; estimated without it.")
    ] = None,
    out: Annotated[Path | None, typer.Option(metavar="FILE", help="Also write the tables to a Markdown file.")] = None,
) -> None:
    """Compare line extractors: the paper's, this project's, split-and-merge, RANSAC and Hough.

    On simulated scans of four families at three levels of noise, with seeds that nothing was tuned on; or on a recorded
    log, where only the share of the beams near a segment can be told.

    [bold]Examples[/bold]

    hopslam bench lines

    hopslam bench lines --seeds 5 --out /tmp/lines.md

    hopslam bench lines --log mines1.dat.gz --sensor urg04lx
    """
    from slam.bench.lines_report import log_tables, scene_tables, write_tables

    tables = scene_tables(seeds, console) if log is None else log_tables(log, console, sensor)
    for table in tables:
        console.print(table.for_terminal())
    if out is not None:
        write_tables(out, tables)


def slam(
    logs: Annotated[
        list[str] | None, typer.Argument(metavar="[LOG]...", help="Names such as fr079; all without one.")
    ] = None,
    data: Annotated[Path, typer.Option(metavar="DIR", help="Where the recorded logs are.")] = Path("../shared/data"),
    settings: Settings = None,
    out: Annotated[Path | None, typer.Option(metavar="FILE", help="Also write the tables to a Markdown file.")] = None,
) -> None:
    """Measure the whole method on recorded logs, with one set of settings for all, beside other systems.

    Every scan, at the pose that the method had for it then. A log that is not there is skipped.

    [bold]Examples[/bold]

    hopslam bench slam

    hopslam bench slam fr079 mines1 --data ~/logs --out /tmp/slam.md

    hopslam bench slam corridor_synthetic --set slam.matching.floor=0.02
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from slam.bench.lines_report import write_tables
    from slam.bench.slam_report import tables
    from slam.scenario.file import load_scenario

    made = tables(logs or [], data, load_scenario("replay", settings or []).slam, console)
    for table in made:
        console.print(table.for_terminal())
    if out is not None:
        write_tables(out, made, "SLAM on recorded logs")


def localize(
    scenarios: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[SCENARIO]...", help="By name or file; two offices without one.", autocompletion=complete_scenario
        ),
    ] = None,
    trials: Annotated[int, typer.Option(min=1, help="Robots that are set down, and then moved, in each.")] = 100,
    seconds: Annotated[float, typer.Option(min=1.0, help="Simulated time of each stay.")] = 10.0,
    seed: Annotated[int, typer.Option(help="Of the places, and of the trials' noise.")] = 1,
    settings: Settings = None,
    allow_modules: AllowModules = None,
) -> None:
    """Measure localisation in a saved map: from a random place, and after the robot was moved without being told.

    One run maps the world of the scenario; the robots wander on their scans alone.

    [bold]Examples[/bold]

    hopslam bench localize

    hopslam bench localize random_office --trials 20 --seed 5 --set seed=3
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from slam.bench.localize_report import localization_table
    from slam.scenario.file import load_scenario

    for name in scenarios or ["office_loop", "random_office"]:
        scenario = load_scenario(name, ["lidar.caster=exact", *(settings or [])], allow_modules or [])
        console.print(localization_table(scenario, trials, seconds, seed, console).for_terminal())


def match(
    scenario: Annotated[
        str, typer.Argument(help="Whose world is scanned: by name or file.", autocompletion=complete_scenario)
    ] = "random_office",
    places: Annotated[int, typer.Option(min=1, help="Where a scan is matched.")] = 40,
    seed: Annotated[int, typer.Option(help="Of the places and the noise.")] = 1,
    png: Annotated[Path | None, typer.Option(metavar="FILE", help="Also draw it.")] = None,
    out: Annotated[Path | None, typer.Option(metavar="FILE", help="Also write the tables to a Markdown file.")] = None,
) -> None:
    """Compare matchers on the same scans: ours, the paper's, and small_gicp's (pip install 'hopslam\\[bench]').

    Time by the number of points, accuracy, and from how far away a start still converges.

    [bold]Examples[/bold]

    hopslam bench match

    hopslam bench match office_loop --places 100 --png match.png --out match.md
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from slam.bench.lines_report import write_tables
    from slam.bench.match_report import compare, draw_comparison, match_tables
    from slam.scenario.file import read_scenario

    found = compare(read_scenario(scenario), places, seed, console)
    tables = match_tables(found)
    for table in tables:
        console.print(table.for_terminal())
    if png is not None:
        draw_comparison(png, found)
    if out is not None:
        write_tables(out, tables, "Matchers on the same scans")


def sweep(
    runs: Annotated[
        int, typer.Option(min=2, help="Of each executor, with one job and with two, in each of five turns.")
    ] = 15,
    ray: Annotated[bool, typer.Option("--ray/--no-ray", help="Ray too: pip install 'hopslam\\[cluster]'.")] = True,
) -> None:
    """Measure sweeps: runs a second with one job and with two, the driver's share of a core, overhead, memory.

    Some minutes. Quiet machines give better numbers: what two processes can do at all is measured in the same run.

    [bold]Examples[/bold]

    hopslam bench sweep

    hopslam bench sweep --runs 6 --no-ray
    """
    from slam.bench.sweep_report import sweep_tables

    for table in sweep_tables(runs, ray, console):
        console.print(table.for_terminal())


def slam_sim(
    scenarios: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[SCENARIO]...", help="Names such as corridor; six without one.", autocompletion=complete_scenario
        ),
    ] = None,
    seeds: Annotated[int, typer.Option(min=0, max=100, help="Runs of each scenario; 0 with --hour alone.")] = 10,
    first_seed: Annotated[int, typer.Option(min=0, help="Of these runs; the others follow.")] = 0,
    hour: Annotated[bool, typer.Option("--hour", help="Also one simulated hour around office_loop: minutes.")] = False,
    settings: Settings = None,
    allow_modules: AllowModules = None,
    out: Annotated[Path | None, typer.Option(metavar="FILE", help="Also write the tables to a Markdown file.")] = None,
) -> None:
    """Measure the whole method in the simulator, against the truth: errors, covariances, costs.

    [bold]Examples[/bold]

    hopslam bench slam-sim

    hopslam bench slam-sim corridor office_loop --first-seed 10 --seeds 3

    hopslam bench slam-sim --seeds 0 --hour

    hopslam bench slam-sim crowded_corridor --set slam.map.free_margin=0.1 --out /tmp/crowd.md
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from slam.bench.lines_report import write_tables
    from slam.bench.sim_report import tables

    runs = range(first_seed, first_seed + seeds)
    made = tables(scenarios or [], runs, hour, tuple(settings or ()), console, tuple(allow_modules or ()))
    for table in made:
        console.print(table.for_terminal())
    if out is not None:
        write_tables(out, made, "SLAM in the simulator")


def viewer(
    scenario: ScenarioName = "corridor",
    scans: Annotated[int, typer.Option(min=10, help="For each row at 10 Hz.")] = 150,
    allow_modules: AllowModules = None,
) -> None:
    """Measure what --rerun costs: milliseconds and kilobytes a scan, in a file, and live when nobody looks.

    Takes about two minutes.

    [bold]Examples[/bold]

    hopslam bench viewer

    hopslam bench viewer office_loop --scans 50
    """
    from slam.bench.viewer_cost import viewer_table
    from slam.scenario.file import load_scenario

    console.print(viewer_table(load_scenario(scenario, [], allow_modules or []), scans, console).for_terminal())


def start(
    scenario: ScenarioName = "corridor",
    repeats: Annotated[int, typer.Option(min=1, help="Starts of each kind.")] = 5,
    allow_modules: AllowModules = None,
) -> None:
    """Measure how long a user waits: for the help, and for the first scan of a run, with warm caches.

    [bold]Examples[/bold]

    hopslam bench start

    hopslam bench start office_loop --repeats 20
    """
    from slam.bench.start_up import start_up_table

    console.print(start_up_table(scenario, repeats, console, allow_modules or []).for_terminal())
