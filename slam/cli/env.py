"""``hopslam env``."""

from typing import Annotated

import typer

from slam.console.terminal import Terminal
from slam.console.terminal_table import TerminalTable


def env(
    env_id: Annotated[str | None, typer.Argument(metavar="ID", help="The environment whose manual to print.")] = None,
) -> None:
    """List the gymnasium environments, or print the manual of one.

    [bold]Examples[/bold]

    hopslam env

    hopslam env hopslam/Corridor-v0

    hopslam env Corridor-v0 | less
    """
    console = Terminal()
    if env_id is None:
        console.print(_id_table())
        console.print("hopslam env ID prints the manual of one")
    else:
        from slam.env.ids import find_env_id, manual

        console.print_markdown(manual(find_env_id(env_id)))


def _id_table() -> TerminalTable:
    from slam.env.ids import ENV_IDS
    from slam.scenario.file import load_scenario

    rows = []
    for env_id, scenario in ENV_IDS.items():
        description = load_scenario(scenario).description if scenario else "any scenario: by name, file or value"
        rows.append((env_id, scenario or "argument", description))
    return TerminalTable(("id", "scenario", "description"), rows)
