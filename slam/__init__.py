"""Line-based SLAM with a planar lidar: arrays and values, no engine and no port."""
