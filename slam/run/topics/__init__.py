"""Topics of a run: published for ROS and Foxglove during the run, with commands from them."""
