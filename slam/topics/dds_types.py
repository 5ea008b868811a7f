"""Topics of DDS whose messages are bytes: CDR passes unchanged."""

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any, Final

from slam.files.ros.messages import ros2_types
from slam.named_code import import_optional

EXTRA: Final = "ros"
"""The extra of this project that installs Cyclone DDS."""
_OPERATIONS: Final = 14
"""Number of functions in Cyclone DDS's table of a type, ``struct ddsi_sertype_ops``."""
_DESCRIPTIONS: Final = slice(8, 11)
"""Functions among them that return its identifier, its map and its information."""

_Operations = ctypes.c_void_p * _OPERATIONS
_OperationsPointer = ctypes.POINTER(_Operations)


def open_dds_topic(participant: Any, name: str, message_type: str) -> Any:
    """Return a topic of DDS for messages of a type such as ``sensor_msgs/msg/LaserScan``.

    A sample has one attribute, ``data``: the bytes of a message. Names of topics and types follow
    https://design.ros2.org/articles/topic_and_service_names.html.
    """
    return import_optional("cyclonedds.topic", EXTRA).Topic(participant, f"rt{name}", _struct(message_type))


@cache
def _struct(message_type: str) -> Any:
    """Return the DDS type of this message, whose values are read and written as bytes in CDR."""
    package, _, short = message_type.split("/")
    fields = {name: _field(kind) for name, kind in ros2_types().fielddefs[message_type][1]}
    declare = import_optional("cyclonedds.idl", EXTRA).make_idl_struct
    struct = declare(short, f"{package}::msg::dds_::{short}_", fields, dataclassify=False)
    struct.__init__ = lambda self, data: setattr(self, "data", data)
    struct.serialize = lambda self, *_, **__: self.data
    struct.deserialize = struct.deserialize_key = classmethod(lambda cls, data, *_, **__: cls(data))
    return struct


def _field(kind: Any) -> Any:
    """Return the type of a field that rosbags describes as a pair (kind, details)."""
    from rosbags.interfaces import Nodetype  # imported here, as rosbags loads slowly

    types = import_optional("cyclonedds.idl.types", EXTRA)
    match kind:
        case (Nodetype.BASE, (base, _)):
            named = {"string": str, "bool": bool, "octet": types.byte, "char": types.uint8}
            return named[base] if base in named else getattr(types, base)
        case (Nodetype.NAME, name):
            return _struct(name)
        case (Nodetype.ARRAY, (element, length)):
            return types.array[_field(element), length]
        case (_, (element, most)):
            return types.sequence[_field(element), most] if most else types.sequence[_field(element)]


@contextmanager
def without_description(topic: Any) -> Iterator[None]:
    """Let other programs match readers and writers made in the block by the name of the type alone.

    Fast DDS 3 matches two topics with descriptions of their types only if the descriptions are equal bit by bit. Those
    of Cyclone DDS and Fast DDS differ for sequences and arrays: only one of them sets TRY_CONSTRUCT1 for elements
    (DDS-XTypes 1.3, section 7.3.4). Cyclone DDS has no setting for this, so the type gets a copy of its table of
    functions without those that describe it. The usual table is restored after the block: Cyclone DDS registered the
    description with it, and needs it to remove the description.
    """
    library = import_optional("cyclonedds.internal", EXTRA).DDS._dll_handle
    sertype = ctypes.POINTER(_OperationsPointer)()
    library.dds_get_entity_sertype(topic._ref, ctypes.byref(sertype))
    usual = ctypes.addressof(sertype[0].contents)
    sertype[0] = _without_description(usual)
    try:
        yield
    finally:
        sertype[0] = ctypes.cast(usual, _OperationsPointer)


@cache
def _without_description(table: int) -> Any:
    """Return a pointer to a copy of the table at this address; it is kept, as topics continue to use it."""
    operations = _Operations(*_Operations.from_address(table))
    operations[_DESCRIPTIONS] = [None] * 3
    return ctypes.pointer(operations)
