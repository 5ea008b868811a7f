"""Converts messages in JSON, as Foxglove sends them, to CDR."""

import json
from typing import Any, Final

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.serde import SerdeError

from slam.files.fields import BadLine
from slam.files.ros.messages import ros2_types

_UNUSABLE: Final = (SerdeError, ValueError, TypeError, LookupError, OverflowError, RecursionError, AttributeError)

_LARGEST: Final = 64 * 1024
"""Longest message, bytes: more than a person or a panel publishes."""


def cdr_of_json(text: bytes, name: str) -> bytes:
    """Return the message of this type in CDR; missing fields are 0. BadLine for an invalid text."""
    if len(text) > _LARGEST:
        raise BadLine("too long")
    try:
        message = _message(name, json.loads(text))
        return bytes(ros2_types().serialize_cdr(message, name))
    except _UNUSABLE as error:
        raise BadLine(f"is not a {name} in JSON") from error


def _message(name: str, given: Any) -> Any:
    if not isinstance(given, dict):
        raise TypeError(f"{name} is given as {type(given).__name__}")
    fields = ros2_types().fielddefs[name][1]
    return ros2_types().types[name](*(_field(definition, given.get(field)) for field, definition in fields))


def _field(definition: Any, given: Any) -> Any:
    """Return the value of a field, or its zero for None."""
    kind, of = definition
    if kind == Nodetype.NAME:
        return _message(of, {} if given is None else given)
    if kind == Nodetype.BASE:
        return _number_or_text(of[0], given)
    (_, (element, _)), length = of
    values = np.array([0] * length if given is None else given, np.dtype(element))
    if values.shape != (length or len(values),):
        raise ValueError(f"{len(values)} values for {length}")
    return values


def _number_or_text(kind: str, given: Any) -> Any:
    if kind == "string":
        return str(given or "")
    return np.dtype(kind).type(given or 0).item()
