"""Topics of ROS 2, and what carries them: DDS for ROS itself, WebSockets for Foxglove."""
