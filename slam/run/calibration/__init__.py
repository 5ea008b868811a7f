"""``hopslam calibrate``: squares driven, and the wheels fitted to them."""
