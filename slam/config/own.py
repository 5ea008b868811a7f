"""A part of the method that is not in this repository."""

from __future__ import annotations

from typing import Any

from pydantic import Field

from slam.config.section import Section


class OwnMethod(Section):
    """An extractor or a matcher of your own: any function or class that Python can import; see docs/extend.md. A file
    that names one runs its code."""

    method: str = Field(pattern=r"^[A-Za-z_][\w.]*:[A-Za-z_]\w*$")
    """``module:name``; the module's folder is on PYTHONPATH, or it is installed."""
    options: dict[str, Any] = Field({})
    """Its keyword arguments."""
