"""Measurements of the simulator: ``hopslam bench sim``."""
