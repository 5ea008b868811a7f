"""Extraction of line segments: the Hough line by SVD (section 3.1), hopping and reverse hop (sections 3.2 and 3.3)."""
