"""A run on topics: published for ROS and Foxglove as it goes, and driven by them."""
