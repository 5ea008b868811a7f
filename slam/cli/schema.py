"""``hopslam schema``."""

import typer


def schema() -> None:
    """Print the JSON schema of scenario files, by which editors complete and check them.

    The one of this version is shipped as scenarios/scenario.schema.json. A scenario says which schema it follows in its
    first line, # yaml-language-server: $schema=PATH.

    [bold]Examples[/bold]

    hopslam schema > scenario.schema.json
    """
    from slam.scenario.json_schema import schema_text

    typer.echo(schema_text(), nl=False)
