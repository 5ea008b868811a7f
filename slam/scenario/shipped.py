"""The scenarios that come with hopslam, and scenarios found by name or path."""

from __future__ import annotations

from contextlib import suppress
from difflib import get_close_matches
from pathlib import Path

from slam.errors import ScenarioError

SHIPPED = next(
    (p for p in (Path(__file__).parents[1] / "scenarios", Path(__file__).parents[2] / "scenarios") if p.is_dir()),
    Path("scenarios"),
)
"""Inside the wheel, or beside the packages in a checkout."""


def shipped_scenarios() -> list[str]:
    """Their names."""
    return sorted(path.stem for path in SHIPPED.glob("*.yaml"))


def find_scenario(name: str | Path, beside: Path = Path()) -> Path:
    """The path of a scenario given by name or by path, which is relative to the folder ``beside``."""
    path, shipped = beside / name, SHIPPED / f"{name}.yaml"
    with suppress(OSError):  # a name too long for a file
        if path.is_file():
            return path
        if shipped.is_file():
            return shipped
    known = shipped_scenarios()
    close = get_close_matches(str(name), known, n=1)
    hint = f"did you mean {close[0]}?" if close else f"give a path, or one of: {', '.join(known)}"
    raise ScenarioError(f"no scenario {str(name)!r}: no such file, and none of that name is shipped; {hint}")
