"""Recognises files in formats that hopslam does not read, with advice."""

import re
from typing import Final

_KINDS: Final = (
    (
        re.compile(rb"version https://git-lfs\.github\.com/spec/"),
        "a Git LFS pointer, and the log itself is not here; run: git lfs pull",
    ),
    (
        re.compile(rb"#ROS(RECORD|BAG) V[01]\."),
        "a ROS bag of a format before 2.0; with a ROS 1, convert it: rosbag filter OLD.bag NEW.bag True",
    ),
    (
        re.compile(rb".{0,8}(CSensoryFrame|CAction|CObservation|CRawlog)", re.DOTALL),
        "an MRPT rawlog; give the CARMEN log or the bag from which it was made, or make a CARMEN log of its scans and "
        "odometry (rawlog-edit --export-2d-scans-txt and --export-odometry-txt write them as text)",
    ),
)
_HEAD: Final = 64


def named(begin: bytes) -> str | None:
    """Return the kind of a file with this beginning, and what to do with it; None if it is unknown."""
    return next((kind for pattern, kind in _KINDS if pattern.match(begin[:_HEAD])), None)
