"""Recorded logs, read into SI units whatever they were written in; the format is known by the content."""

from slam.run.logs.log import Log
from slam.run.logs.read import read_log

__all__ = ["Log", "read_log"]
