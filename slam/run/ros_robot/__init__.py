"""A robot of ROS 2, used through its topics only."""
