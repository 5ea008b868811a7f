"""``hopslam bench`` of the method and its parts: paper, lines, match, localize, slam and slam-sim."""

from pathlib import Path
from typing import Annotated

import typer

from slam.cli.bench import TablesFile, console, print_tables, use_one_thread
from slam.console.options import AllowModules, Settings, complete_scenario
from slam.errors import InputError


def bench_paper(
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the report and the pictures.")] = Path(
        "bench/paper"
    ),
    quick: Annotated[
        bool, typer.Option("--quick", help="Use fewer points and trials; takes seconds instead of minutes.")
    ] = False,
) -> None:
    """Measure Table 2, Figs. 3, 7, 8 and 10 and the time of Fig. 21 again, compared with the paper's numbers.

    Table 2 takes some minutes, nearly all of them in the SVD with the whole matrix U, as in the paper.

    [bold]Examples[/bold]

    hopslam bench paper --quick

    hopslam bench paper --out /tmp/paper
    """
    use_one_thread()
    from slam.bench.paper.report import reproduce

    report = reproduce(out, quick, console)
    print_tables(report.tables)
    console.print(f"report and pictures in {report.path.parent}")


def bench_lines(
    log: Annotated[
        Path | None, typer.Option(metavar="FILE", help="A recorded log, instead of simulated scans.")
    ] = None,
    seeds: Annotated[int, typer.Option(min=1, max=60, help="Seeds of each family of floor plan.")] = 60,
    sensor: Annotated[
        str | None, typer.Option(metavar="NAME", help="With --log: sensor whose noise is assumed before it is learnt.")
    ] = None,
    out: TablesFile = None,
) -> None:
    """Compare line extractors: the paper's, this project's, split-and-merge, RANSAC and Hough.

    Scans are simulated, four families at three levels of noise, with seeds that were not used for tuning; or recorded,
    for which only the share of the beams near a segment is known.

    [bold]Examples[/bold]

    hopslam bench lines

    hopslam bench lines --seeds 5 --out /tmp/lines.md

    hopslam bench lines --log mines1.dat.gz --sensor urg04lx
    """
    from slam.bench.lines_report import log_tables, scene_tables

    tables = scene_tables(seeds, console) if log is None else log_tables(log, console, sensor)
    print_tables(tables, out, "Line extractors side by side")


def bench_match(
    scenario: Annotated[
        str, typer.Argument(help="Scenario, by name or file, whose world is scanned.", autocompletion=complete_scenario)
    ] = "random_office",
    places: Annotated[int, typer.Option(min=1, help="Number of places at which a scan is matched.")] = 40,
    seed: Annotated[int, typer.Option(help="Seed of the places and the noise.")] = 1,
    png: Annotated[Path | None, typer.Option(metavar="FILE", help="Also draw the results.")] = None,
    out: TablesFile = None,
) -> None:
    """Compare matchers on the same scans: ours, the paper's, and small_gicp's (pip install 'hopslam\\[bench]').

    The tables show time over the number of points, accuracy, and the start errors from which a match converges.

    [bold]Examples[/bold]

    hopslam bench match

    hopslam bench match office_loop --places 100 --png match.png --out match.md
    """
    use_one_thread()
    from slam.bench.match_report import compare_matchers, draw_comparison, match_tables
    from slam.files.atomic_files import require_writable
    from slam.scenario.file import read_scenario

    found = compare_matchers(read_scenario(scenario), places, seed, console)
    print_tables(match_tables(found), out, "Matchers on the same scans")
    if png is not None:
        with require_writable(png, "choose another --png FILE"):
            draw_comparison(png, found)


def bench_localize(
    scenarios: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[SCENARIO]...", help="Names or files; default: two offices.", autocompletion=complete_scenario
        ),
    ] = None,
    trials: Annotated[
        int, typer.Option(min=1, help="Robots that are placed, and later moved, in each scenario.")
    ] = 100,
    seconds: Annotated[float, typer.Option(min=1.0, help="Simulated time of each stay.")] = 10.0,
    seed: Annotated[int, typer.Option(help="Seed of the places and of the trials' noise.")] = 1,
    settings: Settings = None,
    allow_modules: AllowModules = None,
) -> None:
    """Measure localisation in a saved map, from a random place, and after the robot was carried to another one.

    One run maps the world of the scenario; the robots wander by their scans alone.

    [bold]Examples[/bold]

    hopslam bench localize

    hopslam bench localize random_office --trials 20 --seed 5 --set seed=3
    """
    use_one_thread()
    from slam.bench.localize_report import localization_table
    from slam.scenario.file import load_scenario

    for name in scenarios or ["office_loop", "random_office"]:
        scenario = load_scenario(name, ["lidar.caster=exact", *(settings or [])], allow_modules or [])
        print_tables([localization_table(scenario, trials, seconds, seed, console)])


def bench_slam(
    logs: Annotated[
        list[str] | None, typer.Argument(metavar="[LOG]...", help="Names such as fr079; default: all.")
    ] = None,
    data: Annotated[Path, typer.Option(metavar="DIR", help="Folder of the recorded logs.")] = Path("../shared/data"),
    stress: Annotated[
        bool,
        typer.Option(
            "--stress", help="Run harder variants of fr079, fr101, belgioioso and aces instead; takes minutes."
        ),
    ] = False,
    variants: Annotated[
        list[str] | None,
        typer.Option("--variant", metavar="NAME=X,...", help="With --stress: only this variant; may be given again."),
    ] = None,
    seeds: Annotated[int, typer.Option(min=1, help="With --stress: runs of each variant.")] = 5,
    settings: Settings = None,
    out: TablesFile = None,
) -> None:
    """Measure the whole method on recorded logs, with the same settings for all, compared with other systems.

    Each scan counts with its pose as estimated at the time. Missing logs are skipped.

    With --stress, logs are made harder: fewer scans (every=N) or beams (beams=N); odometry with noise (jitter=METRES),
    wrong distances (scale=SHARE), turned headings (slips=COUNT), missing motions (blind=COUNT) or a delay of one scan
    (stale=SHARE); ranges that are rounded (coarse=METRES), noisy (noise=METRES) or cut short (scatter=SHARE). See
    docs/slam.md. Any log can be used that has a reference file LOG.gt.tum or LOG.relations.gz in its folder.

    [bold]Examples[/bold]

    hopslam bench slam

    hopslam bench slam fr079 mines1 --data ~/logs --out /tmp/slam.md

    hopslam bench slam corridor_synthetic --set slam.matching.floor=0.02

    hopslam bench slam --stress

    hopslam bench slam fr079 --stress --variant every=5,blind=10 --variant beams=2 --seeds 2
    """
    use_one_thread()
    from slam.bench.slam_report import slam_tables
    from slam.bench.stress.stress_report import stress_tables
    from slam.scenario.file import load_scenario

    if variants and not stress:
        raise InputError("--variant: needs --stress")
    config = load_scenario("replay", settings or []).slam
    if stress:
        tables = stress_tables(logs or [], data, variants or [], seeds, config, console)
    else:
        tables = slam_tables(logs or [], data, config, console)
    print_tables(tables, out, "SLAM on recorded logs")


def bench_slam_sim(
    scenarios: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[SCENARIO]...", help="Names such as corridor; default: six.", autocompletion=complete_scenario
        ),
    ] = None,
    seeds: Annotated[int, typer.Option(min=0, max=100, help="Runs of each scenario; 0 for --hour alone.")] = 10,
    first_seed: Annotated[int, typer.Option(min=0, help="Seed of the first run; the others follow.")] = 0,
    hour: Annotated[
        bool, typer.Option("--hour", help="Also drive one simulated hour around office_loop; takes minutes.")
    ] = False,
    settings: Settings = None,
    allow_modules: AllowModules = None,
    out: TablesFile = None,
) -> None:
    """Measure the whole method in the simulator, against the truth: errors, covariances, costs.

    [bold]Examples[/bold]

    hopslam bench slam-sim

    hopslam bench slam-sim corridor office_loop --first-seed 10 --seeds 3

    hopslam bench slam-sim --seeds 0 --hour

    hopslam bench slam-sim crowded_corridor --set slam.map.free_margin=0.1 --out /tmp/crowd.md
    """
    use_one_thread()
    from slam.bench.sim_report import sim_tables

    runs = range(first_seed, first_seed + seeds)
    tables = sim_tables(scenarios or [], runs, hour, tuple(settings or ()), console, tuple(allow_modules or ()))
    print_tables(tables, out, "SLAM in the simulator")


def bench_walls(
    scenarios: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[SCENARIO]...", help="Names or files; default: four.", autocompletion=complete_scenario
        ),
    ] = None,
    seeds: Annotated[int, typer.Option(min=1, max=1000, help="Runs of each scenario.")] = 10,
    first_seed: Annotated[int, typer.Option(min=0, help="Seed of the first run; the others follow.")] = 0,
    settings: Settings = None,
    allow_modules: AllowModules = None,
    out: TablesFile = None,
) -> None:
    """Measure the line map against the true walls in the simulator, compared with other line maps of the same poses.

    The last table has the command that repeats the worst run of each scenario.

    [bold]Examples[/bold]

    hopslam bench walls

    hopslam bench walls office_loop my_flat.yaml --seeds 3 --out /tmp/walls.md
    """
    use_one_thread()
    from slam.bench.walls_report import wall_tables

    runs = range(first_seed, first_seed + seeds)
    tables = wall_tables(scenarios or [], runs, tuple(settings or ()), console, tuple(allow_modules or ()))
    print_tables(tables, out, "Line maps against the true walls")
