"""Matchers of a scan to the map: the force field of section 4.2, and least squares on surfels."""
