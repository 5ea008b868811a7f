"""Prints the lines and branches that tests run, by package, from a report of ``coverage json``: see ``make coverage``.

Exits with 1 where tests run fewer than 95 % of the lines or of the branches of a package of the core.
"""

import json
import sys
from collections import Counter
from pathlib import Path
from typing import Final

PACKAGES: Final = ("hopslam", "sim", "slam", "hardware")
LEAST: Final = 95.0
"""Percent, for each package of the core."""


def shares(files: dict[str, dict[str, Counter[str]]], package: str) -> tuple[float, float]:
    """Return the lines and branches that tests run, percent: of a package, or of all files if its name is empty."""
    total: Counter[str] = Counter()
    for name, file in files.items():
        if name.startswith(package):
            total.update({key: file["summary"][key] for key in ("num_statements", "num_branches")})
            total.update({key: file["summary"][key] for key in ("covered_lines", "covered_branches")})
    lines, branches = max(total["num_statements"], 1), max(total["num_branches"], 1)
    return 100.0 * total["covered_lines"] / lines, 100.0 * total["covered_branches"] / branches


def main(report: Path, core: list[str]) -> int:
    """Print the table; returns the exit code."""
    files, low = json.loads(report.read_text())["files"], []
    print(f"{'':16} lines % branches %")
    for package in [*PACKAGES, "", *core]:
        lines, branches = shares(files, package and f"{package}/")
        print(f"{package or 'all':16} {lines:7.1f} {branches:10.1f}")
        if package in core and min(lines, branches) < LEAST:
            low.append(package)
    if low:
        print(f"below {LEAST:.0f} %: {', '.join(low)}")
    return 1 if low else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), sys.argv[2:]))
