"""Loops closed: submaps and key scans, the constraints between them, and the map that is right as a whole."""
