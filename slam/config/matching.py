"""Settings of matching, in SI units and radians; those of the paper have its names."""

from typing import Annotated, Literal

from pydantic import Field, Tag

from slam.config.section import OWN, OwnMethod, Section, by_method


class ForceFieldConfig(Section):
    """Matching of map points to segments, section 4.2."""

    method: Literal["force_field"] = "force_field"
    """The name of this method."""
    gamma_f: float = Field(0.001, gt=0)
    """Gain of the translation, eq. (24)."""
    kappa: float = Field(3.0, gt=0)
    """Exponent with which the force falls with distance, eq. (24)."""
    epsilon: float = Field(0.0001, gt=0)
    """Softening of the force, eq. (24), m^kappa: the force peaks at (epsilon / 2)^(1/3) = 3.7 cm for kappa = 3."""
    gamma_M: float = Field(10.0, gt=0)
    """Gain of the rotation, eq. (32), rad/m^2."""
    average: Literal["printed", "weighted"] = "printed"
    """Average of eq. (33). ``printed``: over all N_Seg N* pairs of segment and point. It oscillates and never converges
    when few segments are in view or the scene is large. ``weighted``, not in the paper: the sum of the forces is
    divided by the sum of their weights 1 / (|lambda|^kappa + epsilon), and that of the moments by the weighted moment
    of inertia. Then gamma_f has no effect, and gamma_M is a number without a unit, best near 1."""
    xi: float = Field(0.99, ge=0, le=1)
    """Leak of eqs. (34)-(35)."""
    eta: float = Field(1.0, gt=0)
    """Proportional gain of eqs. (34)-(35)."""
    zeta: float = Field(0.01, ge=0)
    """Integral gain of eqs. (34)-(35)."""
    rho_f: float = Field(1e-5, gt=0)
    """The iteration ends when the translation correction is below this, metres, and the rotation below ``rho_M``."""
    rho_M: float = Field(1e-5, gt=0)
    """The iteration ends when the rotation correction is below this, radians, and the translation below ``rho_f``."""
    max_iterations: int = Field(1000, ge=1)
    """Upper limit of the number of iterations q."""


class MotionConfig(Section):
    """Trust in odometry: standard deviations of one motion, in the frame of the base."""

    along: float = Field(0.2, gt=0)
    """Standard deviation along the motion, metres for every metre."""
    across: float = Field(0.1, gt=0)
    """Standard deviation across the motion, metres for every metre."""
    turn: float = Field(0.2, gt=0)
    """Standard deviation of a turn, radians for every radian."""
    turn_by_travel: float = Field(0.1, gt=0)
    """Standard deviation of the heading, radians for every metre."""
    least: float = Field(0.005, gt=0)
    """Least standard deviation of a motion, metres and radians."""
    most_growth: float = Field(50.0, ge=1)
    """Largest factor by which the variances grow while the scans keep contradicting the odometry."""
    memory: float = Field(0.8, ge=0, lt=1)
    """Share of the last growth that is kept at the next scan."""
    without_odometry: float = Field(0.15, gt=0)
    """Least standard deviation of a motion without odometry, metres and radians."""
    speed_without_odometry: float = Field(0.5, gt=0)
    """Standard deviation of the speed without odometry, m/s and rad/s: the uncertainty of the motion grows with the
    time between scans."""


class SearchConfig(Section):
    """The coarse search, for odometry with large errors."""

    below: float = Field(0.4, ge=0, le=1)
    """Search if a smaller share of the scan than this agrees with the map."""
    distance: float = Field(0.3, ge=0)
    """Search after a motion of more than this, metres, or if three standard deviations of the prior are more."""
    angle: float = Field(0.3, ge=0)
    """Search after a turn of more than this, radians, or if three standard deviations of the prior are more."""
    window: float = Field(1.5, gt=0)
    """Largest search window to each side, metres; it covers three standard deviations of the prior."""
    window_angle: float = Field(0.6, gt=0)
    """Largest search window of the heading to each side, radians; it covers three standard deviations of the prior."""
    window_angle_without_odometry: float = Field(1.5, gt=0)
    """Largest search window of the heading to each side without odometry, radians."""
    anywhere: float = Field(2.0, ge=0)
    """After a doubtful match the search tries every heading within this distance of the last pose, metres, plus the
    distance that the wheels measured; 0 for never."""
    reach: float = Field(15.0, gt=0)
    """Walls farther than this from the sensor, metres, are ignored."""
    gain: float = Field(1.5, ge=0)
    """A pose found by search is accepted if this many more pieces of the scan agree with the map there."""
    prior_weight: float = Field(0.2, ge=0)
    """Weight of half the squared Mahalanobis distance to the prior, relative to the number of pieces that agree."""


class LeastSquaresConfig(Section):
    """Matching of this project: the pieces of wall of the scan to the surfels of the map, with odometry as prior."""

    method: Literal["least_squares"] = "least_squares"
    """The name of this method."""
    facet_length: float = Field(0.2, gt=0)
    """Segments are matched in pieces no longer than this, metres."""
    gate: float = Field(0.4, gt=0)
    """A piece is matched to a surfel nearer than this, metres."""
    floor: float = Field(0.01, gt=0)
    """Standard deviation added to every piece, metres, more for a coarse sensor: real walls are not perfectly flat."""
    kernel: float = Field(0.03, gt=0)
    """Residuals far above this, metres, more for a coarse sensor, lose their weight (Geman-McClure kernel)."""
    first_kernel: float = Field(0.6, gt=0)
    """Kernel of the first iteration, metres; it is halved at every iteration until it equals ``kernel``."""
    max_iterations: int = Field(12, ge=1)
    """Largest number of Gauss-Newton iterations."""
    tolerance: float = Field(1e-4, gt=0)
    """The iteration ends when a step is below this, metres and radians together."""
    lever: float = Field(2.0, gt=0)
    """Lever, metres: a turn of one radian counts as this much motion when directions are compared."""
    weak: float = Field(0.001, ge=0, lt=1)
    """A direction is unconstrained if the scan's information there is less than this share of that in its best
    direction."""
    correlation: float = Field(4.0, ge=1)
    """Errors of neighbouring pieces and of successive scans are correlated: their information is divided by this."""
    lost_below: float = Field(0.3, ge=0, le=1)
    """The robot is lost if a smaller share of the pieces than this agrees with the map, ``lost_after`` times in a
    row."""
    lost_after: int = Field(5, ge=1)
    """Number of scans in a row with a share below ``lost_below`` after which the robot is lost."""
    directions: Literal["auto", "never"] = "auto"
    """Use of main directions: if most walls of the building have one of a few directions, the long walls of a scan
    measure its heading. ``auto`` does so once it has seen enough of them."""
    motion: MotionConfig = MotionConfig()
    search: SearchConfig = SearchConfig()


MatchConfig = Annotated[
    Annotated[ForceFieldConfig, Tag("force_field")]
    | Annotated[LeastSquaresConfig, Tag("least_squares")]
    | Annotated[OwnMethod, Tag(OWN)],
    by_method("least_squares"),
]
"""The matcher; ``method`` chooses the section. A custom matcher keeps its map in its own way."""
