"""Sections, the parts of a configuration: their base class, the choice between them, and a user's own code."""

from collections.abc import Callable, Mapping
from typing import Any, Final, Self

from pydantic import BaseModel, ConfigDict, Discriminator, Field, PrivateAttr, ValidationInfo, field_validator

from slam.named_code import PLACE, call, find_code, is_allowed, refusal

OWN: Final = "module:name"
"""Tag of a section whose method is not in this repository; the method is then written ``module:name``."""
ALLOWED: Final = "allow_modules"
"""Key of pydantic's validation context: the modules and ``module:name`` places whose code the user allows.

Without it a configuration that names code can be read, but the code cannot be called.
"""


class Section(BaseModel):
    """A part of a configuration: immutable, and an unknown key is an error."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


def by_method(default: str) -> Discriminator:
    """Distinguish the sections of a union by their ``method``.

    It is ``default`` if a section has none, and ``OWN`` for one that is written ``module:name``.
    """

    def method(section: Any) -> str | None:
        name = section.get("method", default) if isinstance(section, dict) else getattr(section, "method", None)
        return OWN if ":" in str(name) else name if name is None else str(name)

    return Discriminator(method)


class OwnMethod(Section):
    """A custom extractor or matcher: any function or class that Python can import.

    See docs/extend.md. A file only names it: the code runs if you allow its module, with `--allow-module`.
    """

    method: str = Field(pattern=PLACE)
    """``module:name``; the module's folder is on PYTHONPATH, or it is installed."""
    options: dict[str, Any] = Field({})
    """Keyword arguments of the call."""
    _allowed: tuple[str, ...] = PrivateAttr(())
    """The permission; never written to a file, nor read from one."""

    @classmethod
    def of(cls, code: Callable[..., Any], **options: Any) -> Self:
        """Make the section that names this function or class, which must be at the top of a module, and allow it."""
        place = f"{code.__module__}:{code.__qualname__}"
        return cls.model_validate({"method": place, "options": options}, context={ALLOWED: (place,)})

    @field_validator("method")
    @classmethod
    def _is_allowed(cls, method: str, info: ValidationInfo) -> str:
        allowed = _allowed_in(info.context)
        if allowed is not None and not is_allowed(method, allowed):
            raise ValueError(refusal(method))
        return method

    def model_post_init(self, context: Any, /) -> None:
        """Copy the permission from the validation context."""
        self._allowed = _allowed_in(context) or ()

    def call(self, *arguments: Any, **more: Any) -> Any:
        """Call the code, and return its result; InputError, of one line, if it is not allowed or found, or fails."""
        return call(self.method, find_code(self.method, self._allowed), *arguments, options=self.options, **more)


def _allowed_in(context: Any) -> tuple[str, ...] | None:
    """Return the allowed code of a validation context; None if the context does not restrict it."""
    allowed = context.get(ALLOWED) if isinstance(context, Mapping) else None
    return None if allowed is None else tuple(allowed)
