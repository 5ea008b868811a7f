"""``hopslam bench`` sweep, viewer, start and ros: times that a user waits for."""

from pathlib import Path
from typing import Annotated

import typer

from slam.cli.bench import console, print_tables
from slam.console.options import AllowModules, ScenarioName, complete_scenario

BenchScenario = Annotated[str, typer.Option(help="Scenario to drive in.", autocompletion=complete_scenario)]


def bench_sweep(
    runs: Annotated[
        int, typer.Option(min=2, help="Runs of each executor and number of jobs, in each of five repetitions.")
    ] = 15,
    ray: Annotated[
        bool, typer.Option("--ray/--no-ray", help="Also run on Ray: pip install 'hopslam\\[cluster]'.")
    ] = True,
) -> None:
    """Measure sweeps: runs per second with one and two jobs, the driver's share of a core, overhead, memory.

    Takes some minutes, best on an idle machine. For comparison, the speed-up of two processes without sweeps is
    measured too.

    [bold]Examples[/bold]

    hopslam bench sweep

    hopslam bench sweep --runs 6 --no-ray
    """
    from slam.bench.sweep_report import sweep_tables

    print_tables(sweep_tables(runs, ray, console))


def bench_viewer(
    scenario: ScenarioName = "corridor",
    scans: Annotated[int, typer.Option(min=10, help="Scans for each row, at 10 Hz.")] = 150,
    allow_modules: AllowModules = None,
) -> None:
    """Measure the cost of --rerun: milliseconds and kilobytes per scan, for a file, with and without a viewer.

    Takes about two minutes.

    [bold]Examples[/bold]

    hopslam bench viewer

    hopslam bench viewer office_loop --scans 50
    """
    from slam.bench.viewer_cost import viewer_table
    from slam.scenario.file import load_scenario

    print_tables([viewer_table(load_scenario(scenario, [], allow_modules or []), scans, console)])


def bench_start(
    scenario: ScenarioName = "corridor",
    repeats: Annotated[int, typer.Option(min=1, help="Number of starts of each kind.")] = 5,
    allow_modules: AllowModules = None,
) -> None:
    """Measure the start-up time of the help, and of a run until its first scan, with warm caches.

    [bold]Examples[/bold]

    hopslam bench start

    hopslam bench start office_loop --repeats 20
    """
    from slam.bench.start_up import start_up_table

    print_tables([start_up_table(scenario, repeats, console, allow_modules or [])])


def bench_ros(
    pythons: Annotated[
        list[Path], typer.Argument(metavar="PYTHON...", help="Python programs with rclpy, one for each ROS 2.")
    ],
    scenario: BenchScenario = "corridor",
    seconds: Annotated[float, typer.Option(min=1.0, help="Time to drive, in real time.")] = 60.0,
    allow_modules: AllowModules = None,
) -> None:
    """Measure --ros: lost scans, their age when a client with rclpy gets them, and the run's time for publishing.

    [bold]Examples[/bold]

    hopslam bench ros .venv-ros/jazzy/bin/python .venv-ros/kilted/bin/python

    hopslam bench ros /usr/bin/python3 --seconds 600
    """
    from slam.bench.ros_report import ros_table
    from slam.scenario.file import load_scenario

    settings = ["physics.engine=plan", "slam.loops=never"]  # a simulated robot waits until the loop is closed
    print_tables([ros_table(load_scenario(scenario, settings, allow_modules or []), pythons, seconds, console)])
