"""Groups of commands that are imported when they are named, or listed by ``--help``."""

from collections import UserDict
from collections.abc import Mapping
from typing import Any

import typer
from typer.core import TyperGroup
from typer.main import get_command

from slam.files.disk import failing_disk
from slam.named_code import import_by_name


class _LazyCommands(UserDict[str, Any]):
    """Click commands by name; before the first use of a command, the value is its place."""

    def __init__(self, places: Mapping[str, str], panels: Mapping[str, str]) -> None:
        super().__init__(places)
        self._panels = panels

    def __getitem__(self, name: str) -> Any:
        found = super().__getitem__(name)
        if isinstance(found, str):
            found = self[name] = self._make(name, found)
        return found

    def _make(self, name: str, place: str) -> Any:
        code = import_by_name(place)
        if not isinstance(code, typer.Typer):
            app = typer.Typer(add_completion=False, rich_markup_mode="rich")
            app.command(name)(code)
            code = app
        command: Any = get_command(code)
        command.name, command.rich_help_panel = name, self._panels.get(name)
        _unwrap_help(command)
        return command


def _unwrap_help(command: Any) -> None:
    """Join the lines of each paragraph, so that a terminal wraps it at its own width; in a group's commands too."""
    command.help = "\n\n".join(" ".join(paragraph.split()) for paragraph in (command.help or "").split("\n\n"))
    inner = getattr(command, "commands", {})
    for one in inner.values() if isinstance(inner, dict) else ():  # a lazy group does the same when a command is used
        _unwrap_help(one)


def lazy_group(places: Mapping[str, str], panels: Mapping[str, str] | None = None) -> type[TyperGroup]:
    """Class of a typer group with these commands: ``module:name`` of a function or of a ``typer.Typer``, by name.

    ``panels`` are the titles under which ``--help`` lists them.
    """

    class LazyGroup(TyperGroup):
        def __init__(self, **attributes: Any) -> None:
            super().__init__(**attributes)
            self.commands = _LazyCommands(places, panels or {})

        def invoke(self, ctx: Any) -> Any:
            """Run the command; a disk that fails in it is a StorageError, unless the command handles it."""
            with failing_disk("make room, or choose another place, and run it again"):
                return super().invoke(ctx)

    return LazyGroup
