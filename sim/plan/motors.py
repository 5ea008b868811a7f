"""The two motors of the P3-DX, which turn its wheels as fast as told within their torque. SI units.

The centre of mass is d behind the axle, m is the mass, I the inertia about the middle of the axle, b the track. Rims
that push with F_l and F_r give

    F_l + F_r = m (dv/dt + d omega^2),    (F_r - F_l) b / 2 = I d omega/dt - m d v omega.
"""

from math import cos
from typing import Final

from sim.wheels import TRACK, WHEEL_RADIUS
from slam.compiled import compiled_on_views

MASS: Final = 9.0
"""kg, of p3dx.urdf like all here."""
MOMENT: Final = 6.8 * 0.06 + 0.2 * 0.211
"""m d, kg m: of body and caster."""
INERTIA: Final = (0.1996 + 6.8 * 0.06**2) + 2.0 * (0.00249 + 1.0 * 0.165**2) + (0.0001 + 0.2 * 0.211**2)
"""I, kg m^2: of body, wheels and caster."""
OWN: Final = MASS / 4.0 + INERTIA / TRACK**2 + 0.00475 / WHEEL_RADIUS**2
"""Force at a rim for the acceleration of that rim, kg; the last part turns the wheel itself ..."""
CROSS: Final = MASS / 4.0 - INERTIA / TRACK**2
"""... and for that of the other rim."""

GIVE: Final = 2.64e-4
"""Speed that PyBullet's solver leaves missing at a rim, m/s for each N s of its motor's push; measured, as is ..."""
LOAD: Final = 0.5
"""... the push, N, that each motor makes besides."""


@compiled_on_views
def give_of(theta: float, seconds: float) -> float:
    """Speed missing at a rim, m/s for each N with which its motor pushes for so many seconds, at this heading.

    The solver splits friction along the axes of the map: most is missing where the robot heads along one of them, and
    nothing halfway between two.
    """
    return GIVE * seconds * (1.0 + cos(4.0 * theta))


@compiled_on_views
def rims_after(
    left: float, right: float, left_target: float, right_target: float, seconds: float, force: float, give: float
) -> tuple[float, float]:
    """Rim speeds after ``seconds`` in which each motor reaches its target, or pushes with ``force`` at most.

    ``give`` is that of ``give_of``, for a motor that is not at its limit.
    """
    pull_left, pull_right = _pulls_of_turning(left, right)
    a, b = (left_target - left) / seconds, (right_target - right) / seconds
    push_left, push_right = OWN * a + CROSS * b + pull_left, CROSS * a + OWN * b + pull_right
    if abs(push_left) > force or abs(push_right) > force:
        if abs(push_left) >= abs(push_right):
            a, b = _limited(push_left, b, pull_left, pull_right, force)
        else:
            b, a = _limited(push_right, a, pull_right, pull_left, force)
        push_left, push_right = OWN * a + CROSS * b + pull_left, CROSS * a + OWN * b + pull_right
    return (
        left + a * seconds - _missing(push_left, force, give),
        right + b * seconds - _missing(push_right, force, give),
    )


@compiled_on_views
def _missing(push: float, force: float, give: float) -> float:
    """Speed that the solver leaves missing at the rim of a motor that pushes so; at its limit nothing."""
    return give * (push + LOAD) if abs(push) < 0.999 * force else 0.0


@compiled_on_views
def _pulls_of_turning(left: float, right: float) -> tuple[float, float]:
    """Forces at the rims that keep their speeds while the robot turns."""
    v, omega = 0.5 * (left + right), (right - left) / TRACK
    ahead, turn = 0.5 * MOMENT * omega * omega, MOMENT * v * omega / TRACK
    return ahead + turn, ahead - turn


@compiled_on_views
def _limited(push: float, other: float, bias: float, other_bias: float, force: float) -> tuple[float, float]:
    """Accelerations of a rim whose motor pushes as it can, and of the other, which shall be ``other``."""
    push = min(max(push, -force), force)
    a = (push - bias - CROSS * other) / OWN
    other_push = CROSS * a + OWN * other + other_bias
    if abs(other_push) > force:
        other_push = min(max(other_push, -force), force) - other_bias
        push -= bias
        det = OWN * OWN - CROSS * CROSS
        return (OWN * push - CROSS * other_push) / det, (OWN * other_push - CROSS * push) / det
    return a, other
