"""The shipped scenarios, and scenarios found by name or path."""

from contextlib import suppress
from pathlib import Path

from slam.errors import ScenarioError, did_you_mean, shown

SHIPPED = next(
    (p for p in (Path(__file__).parents[1] / "scenarios", Path(__file__).parents[2] / "scenarios") if p.is_dir()),
    Path("scenarios"),
)
"""Folder of the shipped scenarios: inside the wheel, or beside the packages in a checkout."""


def shipped_scenarios() -> list[str]:
    """List the names of the shipped scenarios."""
    return sorted(path.stem for path in SHIPPED.glob("*.yaml"))


def find_scenario(name: str | Path, beside: Path = Path()) -> Path:
    """Find the file of a scenario given by name, or by path, relative to the folder ``beside``."""
    if not isinstance(name, str | Path):
        raise ScenarioError(f"scenario: expected a name or a path (got {shown(name)})")
    path, shipped = beside / name, SHIPPED / f"{name}.yaml"
    with suppress(OSError):  # the name is too long for a file
        if path.is_file():
            return path
        if shipped.is_file():
            return shipped
    known = shipped_scenarios()
    hint = did_you_mean(str(name), known, otherwise=f"give a path, or one of: {', '.join(known)}")
    raise ScenarioError(f"no scenario {str(name)!r}: no such file, and none of that name is shipped; {hint}")
