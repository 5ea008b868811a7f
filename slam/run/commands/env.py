"""``hopslam env``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

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
    from rich.markdown import Markdown

    from slam.run.env.catalogue import find_env_id
    from slam.run.env.manual import manual

    console.print(Markdown(manual(find_env_id(env_id))))
