"""The settings of localisation in a saved map, in SI units and radians."""

from __future__ import annotations

from pydantic import Field

from slam.config.section import Section


class LocalizationConfig(Section):
    """Many hypotheses are followed until one has won; agreement is the share of the scan's pieces that lie on walls of
    the map, less what the scan saw through."""

    places: int = Field(400, ge=1)
    """Found by the search over the whole map and refined ..."""
    hypotheses: int = Field(60, ge=1)
    """... of which so many, the best, are followed."""
    seen_through: float = Field(0.5, ge=0)
    """What a piece of wall that the beams went through takes off, against one that agrees."""
    step: float = Field(0.05, gt=0)
    """Evidence is taken after this much motion, metres and radians together: scans from one place say the same."""
    sure_after: int = Field(5, ge=1)
    """Pieces of evidence, at least, before the robot is sure ..."""
    sure_by: float = Field(0.6, gt=0)
    """... that the best hypothesis leads by so much in the sum of agreements ..."""
    sure_above: float = Field(0.6, ge=0, le=1)
    """... and that its agreement, averaged over the last pieces of evidence, is above this."""
    dropped_by: float = Field(1.5, gt=0)
    """A hypothesis that is behind by this much is given up."""
    doubt_below: float = Field(0.5, ge=0, le=1)
    """With an average agreement below this the robot is lost, and the whole map is searched again."""
    memory: float = Field(0.7, ge=0, lt=1)
    """Share of the average that is kept at the next piece of evidence."""
    search_every: int = Field(10, ge=1)
    """Pieces of evidence from one search to the next, while the robot is lost."""
