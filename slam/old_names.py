"""Finds renamed modules under their old names, with a warning that gives the new one."""

import sys
import warnings
from collections.abc import Sequence
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Final

MOVED: Final = {
    "sim.env": "slam.env.p3dx_env",
    "slam.config.own": "slam.config.section",
    "slam.own_code": "slam.named_code",
    "slam.run.bench": "slam.bench",
    "slam.run.cli": "slam.cli.main",
    "slam.run.commands": "slam.cli",
    "slam.run.env": "slam.env",
    "slam.run.env.catalogue": "slam.env.ids",
    "slam.run.env.manual": "slam.env.ids",
    "slam.run.logs": "slam.files.logs",
    "slam.run.logs.replay": "slam.run.replay_robot",
    "slam.run.logs.tum": "slam.files.tum",
    "slam.run.maps": "slam.files.maps",
    "slam.run.pilot": "slam.run.pilots",
    "slam.run.ros": "slam.files.ros",
    "slam.run.scenario": "slam.scenario",
    "slam.run.sweep": "slam.sweep",
    "slam.run.terminal": "slam.console.terminal",
    "slam.run.terminal_table": "slam.console.terminal_table",
}
"""Modules and packages that docs or settings named, by their old names; the longest match counts."""


class _Copy(Loader):
    """Fills a module with an old name with the contents of the renamed module."""

    def __init__(self, new: str) -> None:
        self._new = new

    def exec_module(self, module: ModuleType) -> None:
        own = {"__name__", "__spec__", "__loader__", "__package__"}
        module.__dict__.update({k: v for k, v in vars(import_module(self._new)).items() if k not in own})


class OldNames(MetaPathFinder):
    """Finds a renamed module, and warns with FutureWarning."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return the module with this old name; None for any other name."""
        if not fullname.startswith(("slam.", "sim.")):
            return None
        old = max((name for name in MOVED if f"{fullname}.".startswith(f"{name}.")), key=len, default=None)
        if old is None:
            return None
        new = MOVED[old] + fullname.removeprefix(old)
        warnings.warn(f"{fullname} is an old name: the module is {new} now", FutureWarning, stacklevel=2)
        return ModuleSpec(fullname, _Copy(new), is_package=True)


def find_old_names() -> None:
    """Let Python find renamed modules under their old names; an empty folder of the old name does not hide them."""
    if not any(isinstance(finder, OldNames) for finder in sys.meta_path):
        sys.meta_path.insert(0, OldNames())
