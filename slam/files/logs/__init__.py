"""Recorded logs, converted to SI units; the format is recognised from the content."""

from slam.files.logs.log import BagTopics, Log, Loss
from slam.files.logs.read import read_log

__all__ = ["BagTopics", "Log", "Loss", "read_log"]
