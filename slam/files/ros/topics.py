"""Names of topics, types and frames, as REP-105 and the robots of the field have them."""

from __future__ import annotations

from typing import Final

SCAN: Final = "/scan"
ODOM: Final = "/odom"
TF: Final = "/tf"
TF_STATIC: Final = "/tf_static"
GROUND_TRUTH: Final = "/ground_truth"

LASER_SCAN: Final = "sensor_msgs/msg/LaserScan"
ODOMETRY: Final = "nav_msgs/msg/Odometry"
TRANSFORMS: Final = "tf2_msgs/msg/TFMessage"
POSE: Final = "geometry_msgs/msg/PoseStamped"

TYPES: Final = {SCAN: LASER_SCAN, ODOM: ODOMETRY, TF: TRANSFORMS, TF_STATIC: TRANSFORMS, GROUND_TRUTH: POSE}
"""What is written on each topic."""
