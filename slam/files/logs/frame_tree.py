"""Where frames are fixed to each other, as the transforms of a bag say."""

from __future__ import annotations

from collections.abc import Iterable

from slam.errors import LogError
from slam.files.ros.decoder import Transform
from slam.pose import Pose2D


class FrameTree:
    """The first transform to each frame."""

    def __init__(self, transforms: Iterable[Transform]) -> None:
        self._links: dict[str, Transform] = {}
        for transform in transforms:
            self._links.setdefault(transform.child, transform)

    def mount(self, base: str, sensor: str) -> Pose2D | None:
        """``T_base_sensor``; None where nothing joins them. LogError where the sensor does not lie level."""
        below_base = self._above(base)
        for frame, T_frame_sensor, level in self._above(sensor):
            for other, T_other_base, level_base in below_base:
                if other == frame:
                    if not (level and level_base):
                        raise LogError(f"the transforms from {base} to {sensor} tilt the lidar; need it level")
                    return T_other_base.inverse() @ T_frame_sensor
        return None

    def _above(self, frame: str) -> list[tuple[str, Pose2D, bool]]:
        """The frame and all above it, with the pose of the frame in each, and whether it lies level there."""
        pose, level, above = Pose2D(), True, [(frame, Pose2D(), True)]
        while (link := self._links.get(frame)) is not None and len(above) <= len(self._links):
            frame, pose, level = link.frame, link.pose @ pose, level and link.level
            above.append((frame, pose, level))
        return above
