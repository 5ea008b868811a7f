"""``hopslam bench hardware``: the drivers measured on emulated devices, in real time."""
