"""Topics that a robot of this project publishes and subscribes to, with the names and types of ROS.

All are offered as reliable: a reader that requests best effort, as most readers of sensor data do, gets that, and one
that requests reliable gets every message. Subscriptions request best effort, which every sender offers.
"""

from typing import Final

from slam.files.ros import messages
from slam.topics.topic import Topic

SCAN: Final = Topic(messages.SCAN, messages.LASER_SCAN)
ODOM: Final = Topic(messages.ODOM, messages.ODOMETRY)
TF: Final = Topic(messages.TF, messages.TRANSFORMS)
TF_STATIC: Final = Topic(messages.TF_STATIC, messages.TRANSFORMS, latched=True)
CLOCK: Final = Topic("/clock", messages.CLOCK)
JOINT_STATES: Final = Topic("/joint_states", messages.JOINTS)
BATTERY_STATE: Final = Topic("/battery_state", messages.BATTERY)
MAP: Final = Topic("/map", messages.GRID, latched=True)
LINES: Final = Topic("/lines", messages.MARKERS, latched=True)
SLAM_POSE: Final = Topic("/slam_pose", messages.UNSURE_POSE)
ROBOT_DESCRIPTION: Final = Topic("/robot_description", messages.TEXT, latched=True)

PUBLISHED: Final = (
    TF_STATIC, ROBOT_DESCRIPTION, CLOCK, TF, ODOM, SCAN, JOINT_STATES, BATTERY_STATE, SLAM_POSE, MAP, LINES,
)  # fmt: skip

CMD_VEL: Final = Topic("/cmd_vel", messages.TWIST, reliable=False)
STAMPED_CMD_VEL: Final = Topic("/cmd_vel", messages.STAMPED_TWIST, reliable=False)
INITIAL_POSE: Final = Topic("/initialpose", messages.UNSURE_POSE, reliable=False)
