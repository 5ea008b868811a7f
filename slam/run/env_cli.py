"""``hopslam env``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console

if TYPE_CHECKING:
    from rich.table import Table


def env(
    env_id: Annotated[str | None, typer.Argument(metavar="ID", help="The environment whose manual to print.")] = None,
) -> None:
    """The gymnasium environments: their ids, or the manual of one.

    [bold]Examples[/bold]

    hopslam env

    hopslam env hopslam/Corridor-v0

    hopslam env Corridor-v0 | less
    """
    console = Console()
    if env_id is None:
        console.print(_id_table())
        console.print("hopslam env ID prints the manual of one", highlight=False)
    else:
        _print_manual(console, env_id)


def _id_table() -> Table:
    from rich.table import Table

    from slam.run.env.catalogue import env_ids
    from slam.run.scenario.file import load_scenario

    table = Table("id", "scenario", "", box=None)
    for env_id, scenario in env_ids().items():
        description = load_scenario(scenario).description if scenario else "any scenario: by name, file or value"
        table.add_row(env_id, scenario or "argument", description)
    return table


def _print_manual(console: Console, env_id: str) -> None:
    import inspect

    import gymnasium
    from rich.markdown import Markdown

    from slam.run.env.catalogue import find_env_id

    env_id = find_env_id(env_id)
    with gymnasium.make(env_id) as made:
        console.print(Markdown(f"# {env_id}\n\n{inspect.getdoc(type(made.unwrapped))}\n\n## As built"))
        console.print(_as_built(made.unwrapped))


def _as_built(env: Any) -> Table:
    """The spaces and the clock of this one environment, with its default arguments."""
    from rich.table import Table

    scenario, table = env.scenario, Table(box=None, show_header=False)
    table.add_row("action", str(env.action_space))
    for name, space in env.observation_space.spaces.items():
        table.add_row(f"observation {name}", str(space))
    clock, scan_time = scenario.clock, scenario.lidar.description.lidar.scan_time
    table.add_row(
        "time",
        f"a step is a scan, {scan_time:g} s: {clock.controls_per_scan} control steps "
        f"of {clock.steps_per_control} physics steps of 1/{clock.rate} s",
    )
    table.add_row("scenario", f"{scenario.name}: {scenario.description}")
    return table
