"""Messages of bags in any container, and the topics and message types of ROS."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Final, NamedTuple

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

SCAN: Final = "/scan"
ODOM: Final = "/odom"
TF: Final = "/tf"
TF_STATIC: Final = "/tf_static"
GROUND_TRUTH: Final = "/ground_truth"

LASER_SCAN: Final = "sensor_msgs/msg/LaserScan"
MULTI_ECHO: Final = "sensor_msgs/msg/MultiEchoLaserScan"
ODOMETRY: Final = "nav_msgs/msg/Odometry"
TRANSFORMS: Final = "tf2_msgs/msg/TFMessage"
POSE: Final = "geometry_msgs/msg/PoseStamped"
UNSURE_POSE: Final = "geometry_msgs/msg/PoseWithCovarianceStamped"
TWIST: Final = "geometry_msgs/msg/Twist"
STAMPED_TWIST: Final = "geometry_msgs/msg/TwistStamped"
GRID: Final = "nav_msgs/msg/OccupancyGrid"
MARKERS: Final = "visualization_msgs/msg/MarkerArray"
CLOCK: Final = "rosgraph_msgs/msg/Clock"
JOINTS: Final = "sensor_msgs/msg/JointState"
BATTERY: Final = "sensor_msgs/msg/BatteryState"
TEXT: Final = "std_msgs/msg/String"

TYPES: Final = {SCAN: LASER_SCAN, ODOM: ODOMETRY, TF: TRANSFORMS, TF_STATIC: TRANSFORMS, GROUND_TRUTH: POSE}
"""Message type on each topic of a run."""


class RawMessage(NamedTuple):
    """One message, not yet decoded."""

    topic: str
    type: str
    """Type in the form of ROS 2, such as ``sensor_msgs/msg/LaserScan``; types of ROS 1 are converted."""
    encoding: str
    """``cdr`` or ``ros1``."""
    data: bytes
    time: int
    """Time of logging, nanoseconds."""


def ros2_type(name: str) -> str:
    """Return ``package/msg/Name`` for the ``package/Name`` of ROS 1; the older name of TFMessage is replaced."""
    if name == "tf/tfMessage":
        return "tf2_msgs/msg/TFMessage"
    package, _, rest = name.partition("/")
    return name if "/" in rest or not rest else f"{package}/msg/{rest}"


@cache
def ros2_types() -> Typestore:
    """Message types of ROS 2 Humble; those used here are the same in every later one."""
    from rosbags.typesys import Stores, get_typestore  # imported here: it loads slowly, and only bags need it

    return get_typestore(Stores.ROS2_HUMBLE)


@cache
def ros1_types() -> Typestore:
    """Message types of ROS 1 Noetic, and its transforms, which rosbags leaves out."""
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    store.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", TRANSFORMS))
    return store
