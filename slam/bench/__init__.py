"""Measurements: the tables and figures of the paper, and the line extractors side by side."""
