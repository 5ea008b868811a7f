"""A message of a bag, whatever the container."""

from __future__ import annotations

from typing import NamedTuple


class RawMessage(NamedTuple):
    """One message, not yet decoded."""

    topic: str
    type: str
    """As ROS 2 writes it, such as ``sensor_msgs/msg/LaserScan``; that of ROS 1 is brought to this form."""
    encoding: str
    """``cdr`` or ``ros1``."""
    data: bytes
    time: int
    """When it was logged, nanoseconds."""


def ros2_type(name: str) -> str:
    """``package/msg/Name`` of the ``package/Name`` of ROS 1; the older name of TFMessage is brought to the newer."""
    if name == "tf/tfMessage":
        return "tf2_msgs/msg/TFMessage"
    package, _, rest = name.partition("/")
    return name if "/" in rest or not rest else f"{package}/msg/{rest}"
