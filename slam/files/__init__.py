"""Files that are read and written: logs, ROS messages, saved maps, tables of poses; whole or not at all."""
