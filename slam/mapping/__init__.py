"""Maps made from scans and poses: the points and lines of section 4.1, and the surfels of this project."""
