"""The generators by name."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Discriminator, Tag

from slam.scenario.generators.corridor import CorridorGenerator
from slam.scenario.generators.loop import LoopGenerator
from slam.scenario.generators.office import OfficeGenerator


def _kind(generate: Any) -> str | None:
    """The kind that a section of settings names, or that the section made of them has."""
    kind = generate.get("kind") if isinstance(generate, dict) else getattr(generate, "kind", None)
    return None if kind is None else str(kind)


Generator = Annotated[
    Annotated[CorridorGenerator, Tag("corridor")]
    | Annotated[OfficeGenerator, Tag("office")]
    | Annotated[LoopGenerator, Tag("loop")],
    Discriminator(_kind),
]
"""``kind`` says which, and which of the settings there are."""
