"""The settings of line extraction, named as in the paper where they are the paper's, in SI units and radians."""

from typing import Annotated, Any, Final, Literal, NamedTuple, Self

from pydantic import Field, Tag, model_validator

from slam.config.section import OWN, OwnMethod, Section, by_method
from slam.lidars import LidarName


class HoppingConfig(Section):
    """Line extraction as printed, sections 3.1 to 3.3."""

    method: Literal["paper"] = "paper"
    """This method."""
    sigma_Th: float = Field(25.0 / 1024, ge=1e-5)  # printed without a unit; metres, as the points are
    """Threshold on the smallest singular value sigma_3, metres; below 10 um prefix sums lose it in rounding."""
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


class ChiSquarePreset(NamedTuple):
    """The defaults of ChiSquareConfig that depend on how well the noise is known, and on who uses the segments."""

    merge_cost: float
    min_points: int
    min_length: float
    max_angle_sigma: float
    shared_error: float


SENSOR_NAMED: Final = ChiSquarePreset(
    merge_cost=18.0, min_points=7, min_length=0.14, max_angle_sigma=0.15, shared_error=0.05
)
"""With ``sensor``, everywhere; ``shared_error`` is not used then."""
NOISE_ESTIMATED: Final = ChiSquarePreset(
    merge_cost=24.0, min_points=10, min_length=0.15, max_angle_sigma=1.0, shared_error=0.05
)
"""Without ``sensor``, for extraction by itself: where the noise is only estimated, details are not to be trusted."""
NOISE_ESTIMATED_IN_SLAM: Final = ChiSquarePreset(
    merge_cost=24.0, min_points=5, min_length=0.10, max_angle_sigma=1.0, shared_error=0.02
)
"""Without ``sensor``, as the ``lines`` of a SlamConfig: details too small to be sure of help when the map can confirm
them."""


class ChiSquareConfig(Section):
    """Line extraction of this project: the walls that explain the ranges by the noise of the sensor."""

    method: Literal["chi_square"] = "chi_square"
    """The name of this method."""
    sensor: LidarName | None = None
    """Lidar whose noise to expect, by its name in slam/lidars.py; without it, noise is estimated from every scan."""
    bound_sigmas: float = Field(3.0, gt=0)
    """The bound that the sensor's maker gives for the range error, in standard deviations."""
    shared_error: float = Field(SENSOR_NAMED.shared_error, gt=0)
    """Without a sensor: noise floor for errors common to neighbouring beams, which one scan cannot reveal, metres (in
    SLAM 0.02). Real walls are not quite straight, and what stands before them is no wall at all."""
    merge_cost: float = Field(SENSOR_NAMED.merge_cost, gt=0)
    """Two neighbouring segments are merged where that raises chi-square by less than this (without a sensor 24)."""
    min_points: int = Field(SENSOR_NAMED.min_points, ge=3)
    """Least number of points of a segment (without a sensor 10, in SLAM 5)."""
    min_length: float = Field(SENSOR_NAMED.min_length, ge=0)
    """Least length of a segment, metres (without a sensor 0.15, in SLAM 0.1)."""
    max_angle_sigma: float = Field(SENSOR_NAMED.max_angle_sigma, gt=0)
    """Greatest standard deviation of a segment's direction, radians (without a sensor 1)."""

    @model_validator(mode="before")
    @classmethod
    def _preset_without_a_sensor(cls, given: Any) -> Any:
        return given if not isinstance(given, dict) or given.get("sensor") else NOISE_ESTIMATED._asdict() | given


LineConfig = Annotated[
    Annotated[HoppingConfig, Tag("paper")]
    | Annotated[ChiSquareConfig, Tag("chi_square")]
    | Annotated[OwnMethod, Tag(OWN)],
    by_method("paper"),
]
"""Line extraction; ``method`` chooses the section."""
