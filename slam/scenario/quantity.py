"""Bounds of a number with a unit, whose error names the unit in which the number was perhaps given."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema, core_schema


@dataclass(frozen=True, slots=True)
class Within:
    """Metadata of an annotated float: the least and the largest value that can be meant, in ``unit``.

    A number given in ``wrong_unit``, of which one is ``factor`` units, lies far outside of these bounds, and the error
    converts it. The JSON schema has the bounds too.
    """

    low: float
    high: float
    unit: str
    wrong_unit: str
    factor: float

    def check(self, value: float) -> float:
        """The value; ValueError where it is out of bounds."""
        if self.low <= value <= self.high:
            return value
        bounds = f"at most {self.high:g}" if self.low >= 0 else f"within {self.low:g} and {self.high:g}"
        meant = f"{value:g} {self.wrong_unit} are {value * self.factor:.4g} {self.unit}"
        raise ValueError(f"{self.unit}, {bounds}; {meant}")

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_after_validator_function(self.check, handler(source))

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        shown = handler(schema)
        return shown | {"maximum": self.high} | ({} if "exclusiveMinimum" in shown else {"minimum": self.low})
