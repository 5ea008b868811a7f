"""Report on what the runs of a sweep have in common: tables, comparisons, pictures, one page."""
