"""``hopslam licences``."""

from importlib.metadata import Distribution, distributions
from typing import Final

from slam.console.terminal import Terminal
from slam.console.terminal_table import TerminalTable

_CLASSIFIER: Final = "License :: "
_LONGEST: Final = 80
"""Longest name of a licence, characters; some packages give the whole text instead."""


def licences() -> None:
    """List the installed packages, with their versions and licences.

    [bold]Example[/bold]

    hopslam licences
    """
    rows = sorted((package.name, package.version, licence_of(package)) for package in distributions())
    Terminal().print(TerminalTable(("package", "version", "licence"), list(dict.fromkeys(rows))))


def licence_of(package: Distribution) -> str:
    """Return a package's licence from its metadata: SPDX expression, short text or classifiers; else ``not stated``."""
    metadata = package.metadata
    given = (metadata[key] for key in ("License-Expression", "License") if key in metadata)
    stated = next(given, "").strip()
    if stated and stated != "UNKNOWN" and len(stated) <= _LONGEST and "\n" not in stated:
        return stated
    classes = [name for name in metadata.get_all("Classifier") or () if name.startswith(_CLASSIFIER)]
    return ", ".join(name.rpartition(" :: ")[2] for name in classes) or "not stated"
