"""Line-based SLAM with a 2-D lidar, and what surrounds it: scenarios, runs, environments, sweeps, commands."""

from slam.old_names import find_old_names

find_old_names()
