"""The lidar of a scenario: its model, its mount, and its errors."""

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from slam.config import Section
from slam.lidars import LIDARS, LidarModel, LidarName
from slam.scenario.values import Place, Positive, SmallLength, Within

Offset = Annotated[float, Within(-2.0, 2.0, "m", "mm", 1e-3)]


class Mount(Place):
    """Pose of a sensor on the base: ``T_base_laser``, metres and radians."""

    x: Offset = 0.0
    """Distance ahead of the middle of the axle, metres."""
    y: Offset = 0.0
    """Distance to the left of the middle of the axle, metres."""

    @model_validator(mode="before")
    @classmethod
    def _accept_a_place(cls, given: Any) -> Any:
        return given.model_dump() if type(given) is Place else given


NoiseName = Literal["paper", "datasheet", "realistic", "none"]
"""Names of the noises in ``sim/lidar_noise.py``."""


CasterName = Literal["bullet", "exact"]
"""Names of the ray casters."""


class LidarConfig(Section):
    """The lidar on the robot."""

    model: LidarName = "urg04lx"
    """Model of the lidar: the paper's (its Table 1), or one of Hokuyo or LDROBOT."""
    mount: Mount = Mount(x=0.16)
    """Pose of the lidar on the base."""
    height: SmallLength = 0.30
    """Height of the scan plane above the floor, metres."""
    rolling: bool = True
    """True: each beam fires when the mirror points there, from the sensor's pose at that time; false: all beams fire at
    once."""
    caster: CasterName = "bullet"
    """Ray caster: PyBullet's rays through the mesh of the world, or compiled rays in its plan; same ranges. If
    ``physics.engine`` is plan, the rays are always those in the plan."""
    noise: NoiseName = "paper"
    """``paper``: Gaussian, bounds of Table 1. ``datasheet``: Gaussian, 10 mm up to 1 m and 1 % beyond. ``realistic``:
    by range and incidence, with mixed pixels at edges, lost echoes and warm-up. See docs/simulator.md."""
    bound_sigmas: Positive = 3.0
    """Number of standard deviations in the maker's plus-minus bound. The paper does not state it; 3 is the usual
    reading."""
    dropout: float = Field(0.0, ge=0, le=1)
    """Share of beams that lose their echo at random."""
    reflectivity: Annotated[float, Field(gt=0, le=1)] = 1.0
    """Reflectivity of all surfaces, used by ``realistic`` only: 1 is white paper, 0.1 is dark."""

    @property
    def description(self) -> LidarModel:
        """The model of the lidar with its accuracy."""
        return LIDARS[self.model]

    @property
    def time_increment(self) -> float:
        """Seconds between two beams; 0 if they fire at once."""
        return self.description.time_increment if self.rolling else 0.0
