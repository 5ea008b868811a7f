"""Groups of commands that are imported when they are named, or listed by ``--help``."""

from collections.abc import Iterator, Mapping, MutableMapping
from typing import Any

import typer
from typer.core import TyperGroup
from typer.main import get_command

from slam.named_code import import_by_name


class _LazyCommands(MutableMapping[str, Any]):
    """Click commands by name, each made when it is first asked for."""

    def __init__(self, places: Mapping[str, str], panels: Mapping[str, str]) -> None:
        self._places, self._panels = places, panels
        self._made: dict[str, Any] = {}

    def __getitem__(self, name: str) -> Any:
        if name not in self._made:
            self._made[name] = self._make(name)
        return self._made[name]

    def __setitem__(self, name: str, command: Any) -> None:
        self._made[name] = command

    def __delitem__(self, name: str) -> None:
        del self._made[name]

    def __iter__(self) -> Iterator[str]:
        return iter({**self._places, **self._made})

    def __len__(self) -> int:
        return len({**self._places, **self._made})

    def _make(self, name: str) -> Any:
        code = import_by_name(self._places[name])
        if not isinstance(code, typer.Typer):
            app = typer.Typer(add_completion=False, rich_markup_mode="rich")
            app.command(name)(code)
            code = app
        command: Any = get_command(code)
        command.name, command.rich_help_panel = name, self._panels.get(name)
        return command


def lazy_group(places: Mapping[str, str], panels: Mapping[str, str] | None = None) -> type[TyperGroup]:
    """Class of a typer group with these commands: ``module:name`` of a function or of a ``typer.Typer``, by name.

    ``panels`` are the titles under which ``--help`` lists them.
    """

    class LazyGroup(TyperGroup):
        def __init__(self, **attributes: Any) -> None:
            super().__init__(**attributes)
            self.commands = _LazyCommands(places, panels or {})

    return LazyGroup
