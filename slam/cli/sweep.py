"""``hopslam sweep``: many runs, their table and their report."""

from __future__ import annotations

from itertools import pairwise
from shlex import quote
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from slam.console.options import AllowModules, complete_sweep
from slam.console.terminal import Terminal
from slam.modes import MODES
from slam.system import usable_cores

if TYPE_CHECKING:
    from slam.sweep.launch import Sweep
    from slam.sweep.plan import Plan

console = Terminal()


class _SweepGroup(TyperGroup):
    """``hopslam sweep SCENARIO`` is ``hopslam sweep run SCENARIO``, and ``--ray`` alone is ``--ray local``."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        if args and args[0] not in self.commands and args[0] != "--help":
            args = ["run", *args]
        return super().parse_args(ctx, list(_with_addresses(args)))


def _with_addresses(args: list[str]) -> list[str]:
    """Put ``local`` after a ``--ray`` that no address follows."""
    whole: list[str] = []
    for word, after in pairwise([*args, ""]):
        whole.append(word)
        if word == "--ray" and after not in {"auto", "local"} and ":" not in after:
            whole.append("local")
    return whole


app = typer.Typer(
    cls=_SweepGroup,
    help="Run many scenarios and logs, by mode, settings and seed; sweep SCENARIO... is short for sweep run.",
    no_args_is_help=True,
    add_completion=False,
)

Scenarios = Annotated[
    list[str],
    typer.Argument(
        metavar="SCENARIO|LOG|SWEEP...",
        help="Scenarios by name or file, logs; or one sweep file.",
        autocompletion=complete_sweep,
    ),
]
Seeds = Annotated[str | None, typer.Option(metavar="FIRST:END", help="Seeds from FIRST up to END - 1; default 0:1.")]
Mode = Annotated[
    str | None, typer.Option(metavar="A,B", help=f"Modes, from {', '.join(MODES)}; default: the scenario's.")
]
Grid = Annotated[
    list[str] | None, typer.Option(metavar="KEY=A,B", help="A setting and its values; may be given again.")
]
Sample = Annotated[
    list[str] | None,
    typer.Option(
        metavar="KEY=KIND(..)",
        help="A setting that is drawn for each seed: uniform, loguniform, normal, integer, choice.",
    ),
]
Settings = Annotated[
    list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="A setting of all runs; may be given again.")
]
Jobs = Annotated[int | None, typer.Option(min=1, metavar="N", help="Runs at a time; default: one for each processor.")]
RayAddress = Annotated[
    str | None,
    typer.Option(
        metavar="[ADDRESS]", help="Run on a Ray cluster: auto, or host:port; without a value: a new local one."
    ),
]
Out = Annotated[
    str | None, typer.Option(metavar="DIR", help="Folder for the results, a path or a URL; default sweeps/<name>.")
]
SweepFolder = Annotated[str, typer.Argument(metavar="DIR", help="Folder of a sweep: a path or a URL.")]


@app.command()
def run(
    scenarios: Scenarios,
    seeds: Seeds = None,
    mode: Mode = None,
    grid: Grid = None,
    sample: Sample = None,
    settings: Settings = None,
    allow_modules: AllowModules = None,
    jobs: Jobs = None,
    ray: RayAddress = None,
    out: Out = None,
    retry: Annotated[int, typer.Option(min=0, metavar="N", help="Number of times that a failed run is repeated.")] = 2,
    pictures: Annotated[bool, typer.Option("--pictures", help="Draw map and errors of every run.")] = False,
    plan: Annotated[bool, typer.Option("--plan", help="Only show the planned runs, and the time they need.")] = False,
) -> None:
    """Run all cases without a result. The same command again continues an interrupted sweep and retries failed runs.

    The results are results.parquet in DIR, one row per run, and run folders in DIR/runs. See docs/sweeps.md.

    [bold]Examples[/bold]

    hopslam sweep corridor office_loop --seeds 0:100 --mode hopslam,paper,dead_reckoning

    hopslam sweep corridor --seeds 0:20 --grid slam.matching.floor=0.005,0.01,0.02 --jobs 4 --plan

    hopslam sweep random_office --seeds 0:500 --sample 'robot.odometry.travel_noise=loguniform(1e-3,1e-2)'

    hopslam sweep paper_vs_ours --out /tmp/paper_vs_ours

    hopslam sweep paper_vs_ours --ray auto --out s3://bucket/paper_vs_ours
    """
    from slam.sweep import launch
    from slam.sweep.make_plan import parse_grid, parse_sample

    modes = [word.strip() for word in mode.split(",")] if mode else []
    tried, drawn = dict(map(parse_grid, grid or [])), dict(map(parse_sample, sample or []))
    if plan:
        planned = launch.plan(scenarios, seeds, modes, tried, drawn, settings or [], allow_modules or [])
        _show_plan(planned, launch.folder_of(planned, out), jobs or usable_cores())
        return
    made = launch.sweep(
        scenarios, seeds=seeds, modes=modes, grid=tried, sample=drawn, settings=settings or [], jobs=jobs, ray=ray,
        out=out, retry=retry, pictures=pictures, allow_modules=allow_modules or [], check=False, console=console,
    )  # fmt: skip
    _show_outcome(made)


@app.command()
def report(
    out: SweepFolder,
    metric: Annotated[
        str | None, typer.Option(metavar="COLUMN", help="Column of results.parquet; default ate_rmse_m.")
    ] = None,
) -> None:
    """Write tables, comparisons and pictures of a sweep: report.html and PNG in DIR/report.

    The tables show median, 5 to 95 % and worst of each setting, differences seed by seed with bootstrap intervals, and
    the worst runs with the commands that repeat them.

    [bold]Examples[/bold]

    hopslam sweep report sweeps/paper_vs_ours

    hopslam sweep report sweeps/paper_vs_ours --metric heading_rmse_deg
    """
    from slam.sweep.report.write import write_report

    made = write_report(out, metric)
    for table in made.tables:
        console.print(table.for_terminal())
    for run in [*made.worst[:3], *made.failed[:3]]:
        console.print(f"{run.case}: {run.reason} ({run.id})\n  {run.command}")
    for damage in made.damage:
        console.print(f"warning: {damage}; run the same hopslam sweep again to replace the lost runs")
    console.print(f"report in {made.page}")


@app.command()
def repeat(
    out: SweepFolder,
    run_id: Annotated[str, typer.Argument(metavar="ID", help="The run_id of a row, or its first digits.")],
    pictures: Annotated[bool, typer.Option("--pictures", help="Draw map and errors.")] = False,
    allow_modules: AllowModules = None,
) -> None:
    """Run one row of a sweep again, and compare all its metrics bit for bit; exit code 1 if one differs.

    [bold]Examples[/bold]

    hopslam sweep repeat sweeps/paper_vs_ours 3f2a --pictures
    """
    from slam.sweep.repeat import repeat_run

    again = repeat_run(out, run_id, pictures, allow_modules or [])
    console.print(f"{again.command}\nresults in {again.folder}")
    if again.differences:
        console.print(f"differs in {', '.join(again.differences)}")
        raise typer.Exit(1)
    console.print(f"all {again.compared} columns are the same, bit for bit")


def _show_plan(plan: Plan, out: str, jobs: int) -> None:
    from slam.sweep.plan_table import plan_table

    with console.waiting("timing one run of each kind"):
        table = plan_table(plan, out, jobs)
    console.print(table.for_terminal())


def _show_outcome(made: Sweep) -> None:
    console.print(
        f"{made.done} runs done, {made.failed} of them failed; {made.before} were there already\n"
        f"results in {made.folder}; look at them: hopslam sweep report {quote(made.folder)}",
    )
    if made.interrupted:
        console.print("interrupted; repeat the command to continue")
        raise typer.Exit(130)
