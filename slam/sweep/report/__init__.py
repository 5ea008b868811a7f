"""What the runs of a sweep have in common: tables, comparisons, pictures, one page."""

from slam.sweep.report.write import Report, write_report

__all__ = ["Report", "write_report"]
