"""Recorded logs, read into SI units whatever they were written in; the format is known by the content."""

from slam.files.logs.log import BagTopics, Log, Loss
from slam.files.logs.read import read_log

__all__ = ["BagTopics", "Log", "Loss", "read_log"]
