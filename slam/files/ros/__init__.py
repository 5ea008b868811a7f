"""ROS 2 messages and MCAP files: reading and writing."""
