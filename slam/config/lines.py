"""Settings of line extraction, in SI units and radians; those of the paper have its names."""

from typing import Annotated, Any, Literal, Self

from pydantic import Field, Tag, model_validator

from slam.config.section import OWN, OwnMethod, Section, by_method
from slam.lidars import LidarName


class HoppingConfig(Section):
    """Line extraction as printed, sections 3.1 to 3.3."""

    method: Literal["paper"] = "paper"
    """The name of this method."""
    sigma_Th: float = Field(25.0 / 1024, ge=1e-5)  # the paper gives no unit; metres are assumed, as for the points
    """Threshold on the smallest singular value sigma_3, metres; below 10 um the rounding of prefix sums is larger."""
    L_Th: int = Field(4, ge=3)
    """A segment is kept when it has more than this many points (Proc. 7). The paper gives no value."""
    psi: int = Field(1, ge=0)
    """Hopping factor: points skipped between two tests."""
    kernel: Literal["svd_full", "svd", "prefix_sums"] = "prefix_sums"
    """Test of sigma_3 < sigma_Th: the SVD of A_i(l) with all of U as printed, its singular values alone, or prefix sums
    of A^T A. All find the same segments."""
    split_gap: float = Field(float("inf"), gt=0, allow_inf_nan=True)
    """Not in the paper: neighbouring points farther apart than this, in metres, never share a segment."""

    @model_validator(mode="after")
    def _no_over_hopping(self) -> Self:
        if not self.psi < self.L_Th / 2:
            raise ValueError(
                f"psi = {self.psi} over-hops: it must be below L_Th / 2 = {self.L_Th / 2:g} (section 3.3); "
                f"lower psi or raise L_Th"
            )
        return self


class ChiSquareConfig(Section):
    """Line extraction of this project: the walls that explain the ranges within their noise, which is learnt."""

    method: Literal["chi_square"] = "chi_square"
    """The name of this method."""
    sensor: LidarName | None = None
    """Lidar whose noise is assumed at first, by its name in slam/lidars.py; then the noise is learnt from the scans."""
    bound_sigmas: float = Field(3.0, gt=0)
    """The bound that the sensor's maker gives for the range error, in standard deviations."""
    merge_cost: float = Field(18.0, gt=0)
    """Two neighbouring segments are merged where that raises chi-square by less than this."""
    min_points: int = Field(5, ge=3)
    """Least number of points of a segment."""
    min_length: float = Field(0.10, ge=0)
    """Least length of a segment, metres."""
    max_angle_sigma: float = Field(0.15, gt=0)
    """Greatest standard deviation of a segment's direction, radians."""

    @model_validator(mode="before")
    @classmethod
    def _before_noise_was_learnt(cls, given: Any) -> Any:
        """Drop ``shared_error``, which older settings have."""
        return {k: v for k, v in given.items() if k != "shared_error"} if isinstance(given, dict) else given


LineConfig = Annotated[
    Annotated[HoppingConfig, Tag("paper")]
    | Annotated[ChiSquareConfig, Tag("chi_square")]
    | Annotated[OwnMethod, Tag(OWN)],
    by_method("paper"),
]
"""Line extraction; ``method`` chooses the section."""
