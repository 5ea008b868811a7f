"""The topics of a robot that runs ROS 2."""

from typing import Annotated

from pydantic import StringConstraints

from slam.config import Section

TopicName = Annotated[str, StringConstraints(pattern=r"^/[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*$")]


class RosConfig(Section):
    """Topics that ``--backend ros`` and ``hopslam ros slam`` use; ``/tf`` and ``/tf_static`` are heard besides.

    Domain and reach are those of the environment: see docs/ros.md.
    """

    scan_topic: TopicName = "/scan"
    """LaserScan of the lidar."""
    odom_topic: TopicName = "/odom"
    """Odometry of the base; where nobody sends it, the transforms from odom to the base are taken."""
    command_topic: TopicName = "/cmd_vel"
    """Twist, or TwistStamped, that the base obeys."""
    stamped_commands: bool = False
    """Commands are TwistStamped."""
    reliable: bool = False
    """Ask for every scan and every odometry, which a driver that offers best effort does not send then."""
