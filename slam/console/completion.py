"""Words that the shell offers for an argument that is being typed. No file is opened for them."""

from __future__ import annotations


def complete_scenario(incomplete: str) -> list[str]:
    """Shipped scenarios whose names begin so; where there is none, the shell offers files."""
    from slam.scenario.shipped import shipped_scenarios

    return [name for name in shipped_scenarios() if name.startswith(incomplete)]


def complete_sweep(incomplete: str) -> list[str]:
    """Shipped scenarios and sweeps whose names begin so."""
    from slam.scenario.shipped import SHIPPED

    sweeps = sorted(path.stem for path in (SHIPPED / "sweeps").glob("*.yaml"))
    return [*complete_scenario(incomplete), *(name for name in sweeps if name.startswith(incomplete))]
