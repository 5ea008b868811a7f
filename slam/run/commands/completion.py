"""What the shell offers for an argument that is being typed: only the names of files are looked at."""

from __future__ import annotations


def complete_scenario(incomplete: str) -> list[str]:
    """Shipped scenarios that begin so; where there is none, the shell goes on with files."""
    from slam.run.scenario.shipped import shipped_scenarios

    return [name for name in shipped_scenarios() if name.startswith(incomplete)]


def complete_sweep(incomplete: str) -> list[str]:
    """The same of what ``hopslam sweep`` takes: shipped sweeps too."""
    from slam.run.scenario.shipped import SHIPPED

    sweeps = sorted(path.stem for path in (SHIPPED / "sweeps").glob("*.yaml"))
    return [*complete_scenario(incomplete), *(name for name in sweeps if name.startswith(incomplete))]
