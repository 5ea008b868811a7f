"""ROS 2 messages and MCAP files: what a run leaves behind, and what comes in from elsewhere."""
