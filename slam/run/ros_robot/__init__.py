"""A robot of ROS 2 that is known by its topics only."""
