"""Files: logs, ROS messages, saved maps, tables of poses; each is written completely or not at all."""
