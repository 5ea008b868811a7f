"""The topics of a robot that runs ROS 2."""

from typing import Annotated

from pydantic import StringConstraints

from slam.config import Section

TopicName = Annotated[str, StringConstraints(pattern=r"^/[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*$")]


class RosConfig(Section):
    """Topics of ``--backend ros`` and ``hopslam ros slam``, in addition to ``/tf`` and ``/tf_static``.

    The environment variables of ROS choose the domain and the discovery range: see docs/ros.md.
    """

    scan_topic: TopicName = "/scan"
    """Topic of the lidar's LaserScan."""
    odom_topic: TopicName = "/odom"
    """Topic of the base's odometry; without it, the transforms from odom to the base are used."""
    command_topic: TopicName = "/cmd_vel"
    """Topic of the velocity commands, Twist or TwistStamped."""
    stamped_commands: bool = False
    """True: commands are TwistStamped."""
    reliable: bool = False
    """True: every scan and odometry is requested reliably; a driver that offers best effort then sends none."""
