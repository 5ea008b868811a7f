"""Segments of the present scan and points of the map to a pose: section 4.2."""
