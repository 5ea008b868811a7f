"""The lidar of a scenario: which one, where it sits, and its errors."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from slam.config import Section
from slam.lidars import LidarModel, lidar_model
from slam.run.scenario.values import Place, Positive


class LidarConfig(Section):
    """The lidar on the robot."""

    model: Literal["table1", "urg04lx"] = "urg04lx"
    mount: Place = Place(x=0.16)
    """Where it sits on the base: ``T_base_laser``."""
    height: Positive = 0.30
    """Of the scan plane above the floor, metres."""
    noise: Literal["table1", "none"] = "table1"
    """``table1``: Gaussian, as in the paper's Table 1."""
    bound_sigmas: Positive = 3.0
    """How many standard deviations the maker's plus-minus bound is. The paper does not say; 3 is the usual reading."""
    dropout: float = Field(0.0, ge=0, le=1)
    """Share of beams that get no echo for no reason."""

    @property
    def description(self) -> LidarModel:
        """The sensor of that name."""
        return lidar_model(self.model)
