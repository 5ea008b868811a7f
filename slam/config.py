"""The settings of the method, named as in the paper, in SI units and radians. Defaults are those of section 5.1."""

from __future__ import annotations

from typing import Annotated, Any, Final, Literal, Self

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag, model_validator


class Section(BaseModel):
    """A part of a configuration: immutable, and an unknown key is an error."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class HoppingConfig(Section):
    """Line extraction as printed, sections 3.1 to 3.3."""

    method: Literal["paper"] = "paper"
    sigma_Th: float = Field(25.0 / 1024, ge=1e-5)
    """Threshold on the smallest singular value sigma_3, metres; below 10 um prefix sums lose it in rounding."""
    L_Th: int = Field(4, ge=3)
    """A segment is kept when it has more than this many points (Proc. 7). The paper gives no value."""
    psi: int = Field(1, ge=0)
    """Hopping factor: points skipped between two tests."""
    kernel: Literal["svd_full", "svd", "prefix_sums"] = "prefix_sums"
    """How sigma_3 < sigma_Th is tested: by the SVD of A_i(l) with all of U as printed, by its singular values alone, or
    by prefix sums of A^T A. Same segments."""
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


_WITHOUT_A_SENSOR: Final = {"merge_cost": 24.0, "min_points": 10, "min_length": 0.15, "max_angle_sigma": 1.0}


class ChiSquareConfig(Section):
    """Line extraction of this project: the walls that explain the ranges by the noise of the sensor."""

    method: Literal["chi_square"] = "chi_square"
    sensor: Literal["table1", "urg04lx"] | None = None
    """Whose noise to expect, see slam/lidars.py; without a name it is estimated from every scan."""
    bound_sigmas: float = Field(3.0, gt=0)
    """How many standard deviations the accuracy is that the sensor's maker gives."""
    shared_error: float = Field(0.05, gt=0)
    """Without a sensor: what neighbouring beams share and no scan shows, metres. Real walls are not quite straight, and
    what stands before them is no wall at all."""
    merge_cost: float = Field(18.0, gt=0)
    """Two neighbouring segments become one where that raises chi-square by less than this (24 without a sensor)."""
    min_points: int = Field(7, ge=3)
    """A segment has at least this many points (10 without a sensor) ..."""
    min_length: float = Field(0.14, ge=0)
    """... and this length, metres (0.15 without a sensor) ..."""
    max_angle_sigma: float = Field(0.15, gt=0)
    """... and its direction is at least this sure: one standard deviation, radians (1 without a sensor)."""

    @model_validator(mode="before")
    @classmethod
    def _coarser_without_a_sensor(cls, given: Any) -> Any:
        """Where the noise is only guessed, details are not to be trusted."""
        return given if not isinstance(given, dict) or given.get("sensor") else _WITHOUT_A_SENSOR | given


def _method(lines: Any) -> str | None:
    """The method of a section of settings, or of the section made of them; "paper" where it names none."""
    return str(lines.get("method", "paper")) if isinstance(lines, dict) else getattr(lines, "method", None)


LineConfig = Annotated[
    Annotated[HoppingConfig, Tag("paper")] | Annotated[ChiSquareConfig, Tag("chi_square")], Discriminator(_method)
]
"""Line extraction: ``method`` says how, and which of the settings there are."""


class MapConfig(Section):
    """The point map, section 4.1, and the part of it that is matched, section 5.1."""

    draw: float = Field(0.75, gt=0, le=1)
    """Share of the map points in the sensor's reach that is drawn at random for one matching."""
    reach: float = Field(float("inf"), gt=0, allow_inf_nan=True)
    """Not in the paper: map points farther than this from the sensor, metres, are not matched even where it could see
    them. The paper's sensor sees 4 m; one that sees 80 m would match most of a building at every step."""


class MatchConfig(Section):
    """Matching of map points to segments, section 4.2."""

    gamma_f: float = Field(0.001, gt=0)
    """Gain of the translation, eq. (24)."""
    kappa: float = Field(3.0, gt=0)
    """Exponent of the fall of the force with distance, eq. (24)."""
    epsilon: float = Field(0.0001, gt=0)
    """Softening of the force, eq. (24), m^kappa: the force peaks at (epsilon / 2)^(1/3) = 3.7 cm for kappa = 3."""
    gamma_M: float = Field(10.0, gt=0)
    """Gain of the rotation, eq. (32), rad/m^2."""
    average: Literal["printed", "weighted"] = "printed"
    """How eq. (33) averages. ``printed``: over all N_Seg N* pairs of segment and point, which swings and never settles
    when few segments are in view or the scene is large. ``weighted``, not in the paper: force over the sum of the
    weights 1 / (|lambda|^kappa + epsilon), moment over the weighted moment of inertia; gamma_f then cancels and gamma_M
    is a pure number that belongs near 1."""
    xi: float = Field(0.99, ge=0, le=1)
    """Leak of eqs. (34)-(35)."""
    eta: float = Field(1.0, gt=0)
    """Proportional gain of eqs. (34)-(35)."""
    zeta: float = Field(0.01, ge=0)
    """Integral gain of eqs. (34)-(35)."""
    rho_f: float = Field(1e-5, gt=0)
    """The iteration ends when the translation correction is below this, metres ..."""
    rho_M: float = Field(1e-5, gt=0)
    """... and the rotation correction below this, radians."""
    max_iterations: int = Field(1000, ge=1)
    """Upper limit of the number of iterations q."""


class SlamConfig(Section):
    """The whole method, Fig. 14."""

    lines: LineConfig = HoppingConfig()
    map: MapConfig = MapConfig()
    matching: MatchConfig = MatchConfig()
    odometry: bool = True
    """Start matching from odometry, eqs. (38)-(44); without it from the last pose, as the paper's simulation does."""
    update_distance: float = Field(0.0, ge=0)
    """Extract, match and map only after this much motion since the last time, metres; odometry fills in between. At 0
    every scan is used."""
    update_angle: float = Field(0.2, gt=0)
    """... or after this much turning, radians."""

    @model_validator(mode="after")
    def _steps_need_odometry(self) -> Self:
        if self.update_distance > 0 and not self.odometry:
            raise ValueError("update_distance needs odometry to measure it; set odometry: true, or leave it at 0")
        return self
