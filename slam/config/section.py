"""What every part of a configuration is made of."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ConfigDict, Discriminator


class Section(BaseModel):
    """A part of a configuration: immutable, and an unknown key is an error."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


def by_method(default: str) -> Discriminator:
    """Tells the sections of a union apart by their ``method``; the default where a section names none."""

    def method(section: Any) -> str | None:
        return str(section.get("method", default)) if isinstance(section, dict) else getattr(section, "method", None)

    return Discriminator(method)
