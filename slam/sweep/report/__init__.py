"""Report on the runs of a sweep: tables, comparisons, pictures, one page."""
