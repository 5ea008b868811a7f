"""Topics of ROS 2, and their transports: DDS for ROS itself, WebSockets for Foxglove."""
