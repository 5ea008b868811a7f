"""The lidar of a scenario: which one, where it sits, and its errors."""

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from slam.config import Section
from slam.lidars import LIDARS, LidarModel, LidarName
from slam.scenario.values import Place, Positive, SmallLength, Within

Offset = Annotated[float, Within(-2.0, 2.0, "m", "mm", 1e-3)]


class Mount(Place):
    """Place of a sensor on the base: ``T_base_laser``, metres and radians."""

    x: Offset = 0.0
    """Metres, ahead of the middle of the axle."""
    y: Offset = 0.0
    """Metres, to the left of it."""

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
    """The sensor: the paper's of its Table 1, or Hokuyo's."""
    mount: Mount = Mount(x=0.16)
    """Its place on the base."""
    height: SmallLength = 0.30
    """Height of the scan plane above the floor, metres."""
    rolling: bool = True
    """Each beam is taken when the turning mirror points there, from where the sensor is then; false: all at once."""
    caster: CasterName = "bullet"
    """Ray caster: PyBullet's rays through the mesh of the world, or compiled rays in its plan; same ranges. Where
    ``physics.engine`` is plan, they are always those in the plan."""
    noise: NoiseName = "paper"
    """``paper``: Gaussian, bounds of Table 1. ``datasheet``: Gaussian, 10 mm up to 1 m and 1 % beyond. ``realistic``:
    by range and incidence, with mixed pixels at edges, lost echoes and warm-up. See docs/simulator.md."""
    bound_sigmas: Positive = 3.0
    """Standard deviations in the maker's plus-minus bound. The paper does not say; 3 is the usual reading."""
    dropout: float = Field(0.0, ge=0, le=1)
    """Share of beams that get no echo for no reason."""
    reflectivity: Annotated[float, Field(gt=0, le=1)] = 1.0
    """Reflectivity of all surfaces, which only ``realistic`` uses: 1 is white paper, 0.1 is dark."""

    @property
    def description(self) -> LidarModel:
        """The sensor of that name."""
        return LIDARS[self.model]

    @property
    def time_increment(self) -> float:
        """Seconds between two beams; 0 where they are taken at once."""
        return self.description.time_increment if self.rolling else 0.0
