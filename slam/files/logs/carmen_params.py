"""What a CARMEN log of this project says beyond the messages: ``PARAM`` lines, which other readers pass by.

The messages know neither the time between two beams nor what makes a reading void, and begin in no map.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from slam.files.fields import BadLine, bounded
from slam.files.logs.carmen_message import Message
from slam.pose import FloatArray, Pose2D

PREFIX: Final = b"hopslam_"


class CarmenParams(NamedTuple):
    """Seconds, metres and radians. Where a log has them, a reading of 0 is an error, and ``tv`` and ``rv`` count."""

    time_increment: float
    range_min: float
    start_x: float
    start_y: float
    start_theta: float

    @property
    def start(self) -> Pose2D:
        """``T_map_base`` at the first scan."""
        return Pose2D(self.start_x, self.start_y, self.start_theta)


def param(words: Sequence[bytes]) -> tuple[str, float] | None:
    """Name and value of one of this project's ``PARAM name value ipc_timestamp host logger_timestamp``."""
    if len(words) < 3 or not words[1].startswith(PREFIX):
        return None
    try:
        return words[1].removeprefix(PREFIX).decode(errors="replace"), bounded(words[2:3])[0]
    except BadLine:
        return None


def params_of(values: dict[str, float]) -> CarmenParams | None:
    """The parameters; None where the log does not have them all."""
    known = {name: values[name] for name in CarmenParams._fields if name in values}
    return CarmenParams(**known) if len(known) == len(CarmenParams._fields) else None


def twists(messages: Sequence[Message]) -> FloatArray | None:
    """Linear and angular velocity, (N, 2); None where a message has none that can be read."""
    try:
        rows = [bounded(message.twist) for message in messages]
    except BadLine:
        return None
    return np.array(rows) if all(len(row) == 2 for row in rows) else None
