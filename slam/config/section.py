"""What every part of a configuration is made of."""

from __future__ import annotations

from typing import Any, Final

from pydantic import BaseModel, ConfigDict, Discriminator

OWN: Final = "module:name"
"""The tag of a section whose method is not in this repository, and how that method is written."""


class Section(BaseModel):
    """A part of a configuration: immutable, and an unknown key is an error."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


def by_method(default: str) -> Discriminator:
    """Tells the sections of a union apart by their ``method``; the default where a section names none, and ``OWN`` for
    one that is written ``module:name``."""

    def method(section: Any) -> str | None:
        name = section.get("method", default) if isinstance(section, dict) else getattr(section, "method", None)
        return OWN if ":" in str(name) else name if name is None else str(name)

    return Discriminator(method)
