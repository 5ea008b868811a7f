"""The settings of localisation in a saved map, in SI units and radians."""

from pydantic import Field

from slam.config.section import Section


class LocalizationConfig(Section):
    """Search for the robot in a saved map: hypotheses are tracked until one is clearly best.

    The agreement of a hypothesis is the share of the scan's pieces that lie on walls of the map, minus a penalty for
    walls that the beams went through. Each scan taken after enough motion is a piece of evidence.
    """

    places: int = Field(400, ge=1)
    """Number of places that the search over the whole map finds and refines."""
    hypotheses: int = Field(60, ge=1)
    """Number of the best of these places that become hypotheses."""
    seen_through: float = Field(0.5, ge=0)
    """Penalty for a piece of wall that the beams went through, relative to a piece that agrees."""
    step: float = Field(0.05, gt=0)
    """Motion between two pieces of evidence, the sum of metres and radians; scans from the same place add no
    evidence."""
    sure_after: int = Field(5, ge=1)
    """Least number of pieces of evidence before the robot is sure."""
    sure_by: float = Field(0.6, gt=0)
    """Least lead of the best hypothesis, in the sum of agreements, before the robot is sure."""
    sure_above: float = Field(0.6, ge=0, le=1)
    """Least agreement of the best hypothesis, averaged over the last pieces of evidence, before the robot is sure."""
    dropped_by: float = Field(1.5, gt=0)
    """Lag behind the best hypothesis, in the sum of agreements, at which a hypothesis is dropped."""
    doubt_below: float = Field(0.5, ge=0, le=1)
    """Average agreement below which the robot is lost, and the whole map is searched again."""
    memory: float = Field(0.7, ge=0, lt=1)
    """Weight of the past in the average agreement, at each new piece of evidence."""
    search_every: int = Field(10, ge=1)
    """Pieces of evidence from one search to the next while the robot is lost."""
