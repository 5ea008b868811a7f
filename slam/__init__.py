"""Line-based SLAM with a 2-D lidar, with scenarios, runs, environments, sweeps and commands."""

from slam.old_names import find_old_names

find_old_names()
