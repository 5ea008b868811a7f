"""Scans and poses to a map: the points of section 4.1, and the line segments seen from each pose."""
