"""The message types of ROS, as rosbags has them."""

from __future__ import annotations

from functools import cache

from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from slam.files.ros.topics import TRANSFORMS


@cache
def ros2_types() -> Typestore:
    """Those of ROS 2 Humble; what is used here is the same in every later one."""
    return get_typestore(Stores.ROS2_HUMBLE)


@cache
def ros1_types() -> Typestore:
    """Those of ROS 1 Noetic, and its transforms, which rosbags leaves out."""
    store = get_typestore(Stores.ROS1_NOETIC)
    store.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", TRANSFORMS))
    return store
