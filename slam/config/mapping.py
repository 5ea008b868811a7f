"""The settings of the map, in SI units and radians."""

from typing import Annotated, Literal

from pydantic import Field, Tag

from slam.config.section import Section, by_method


class PointMapConfig(Section):
    """The point map, section 4.1, and the part of it that is matched, section 5.1."""

    method: Literal["points"] = "points"
    """The name of this method."""
    draw: float = Field(0.75, gt=0, le=1)
    """Share of the map points within the sensor's range that is drawn at random for one matching."""
    reach: float = Field(float("inf"), gt=0, allow_inf_nan=True)
    """Not in the paper: map points farther than this from the sensor, metres, are not matched even if it could see
    them. The paper's sensor sees 4 m; one that sees 80 m would match most of a building at every step."""


class SurfelMapConfig(Section):
    """The map of this project: surfels, short pieces of wall, in a grid that covers what was seen."""

    method: Literal["surfels"] = "surfels"
    """The name of this method."""
    cell: float = Field(0.2, gt=0)
    """Side of a cell of the grid, metres; a wall has one surfel in each cell that it crosses."""
    gate: float = Field(0.10, gt=0)
    """A piece of wall joins the surfel of its cell that faces the same side and is nearer than this, metres."""
    max_hits: int = Field(30, ge=1)
    """Number of scans after which a surfel is fixed: what was seen first stays where it is."""
    pose_sigma: float = Field(0.005, gt=0)
    """Standard deviation that the error of the pose adds to a piece of wall, metres."""
    update_distance: float = Field(0.05, ge=0)
    """A scan is added to the map after this much motion, metres, or after a turn of ``update_angle``."""
    update_angle: float = Field(0.05, gt=0)
    """A scan is added to the map after this much turning, radians, or after ``update_distance``."""
    carve_reach: float = Field(8.0, ge=0)
    """Distance from the sensor, metres, up to which surfels fade if a beam went through them."""
    no_echo_reach: float = Field(4.0, ge=0)
    """Length for which a beam without echo counts as free, metres."""
    free_margin: float = Field(0.25, gt=0)
    """Distance by which a beam must pass a surfel to count as going through it, metres."""
    miss_ratio: float = Field(0.5, gt=0)
    """A surfel is removed when its misses exceed two plus this times its hits."""


MapConfig = Annotated[
    Annotated[PointMapConfig, Tag("points")] | Annotated[SurfelMapConfig, Tag("surfels")], by_method("surfels")
]
"""The map; ``method`` chooses the section."""
