"""The two motors of the P3-DX, which turn its wheels at the commanded speeds within their torque. SI units.

The centre of mass is d behind the axle, m is the mass, I the inertia about the middle of the axle, b the track. Rims
that push with F_l and F_r give

    F_l + F_r = m (dv/dt + d omega^2),    (F_r - F_l) b / 2 = I d omega/dt - m d v omega.
"""

from math import cos
from typing import Final

from sim.wheels import TRACK, WHEEL_RADIUS
from slam.compiled import compiled_on_views

MASS: Final = 9.0
"""Mass of the robot, kg; like all values here from p3dx.urdf."""
MOMENT: Final = 6.8 * 0.06 + 0.2 * 0.211
"""m d, kg m: body and caster."""
INERTIA: Final = (0.1996 + 6.8 * 0.06**2) + 2.0 * (0.00249 + 1.0 * 0.165**2) + (0.0001 + 0.2 * 0.211**2)
"""I, kg m^2: body, wheels and caster."""
OWN: Final = MASS / 4.0 + INERTIA / TRACK**2 + 0.00475 / WHEEL_RADIUS**2
"""Force at a rim per acceleration of that rim, kg; the last term accelerates the wheel itself."""
CROSS: Final = MASS / 4.0 - INERTIA / TRACK**2
"""Force at a rim per acceleration of the other rim, kg."""

COMPLIANCE: Final = 2.64e-4
"""Shortfall of the rim speed in PyBullet's solver per N s of the motor's push, m/s; measured."""
LOAD: Final = 0.5
"""Additional push of each motor, N; measured."""


@compiled_on_views
def solver_compliance(theta: float, seconds: float) -> float:
    """Return the shortfall of the rim speed in PyBullet's solver at this heading, m/s per N of push for ``seconds``.

    The solver splits friction along the axes of the map: the shortfall is largest if the robot heads along one of
    them, and zero halfway between two.
    """
    return COMPLIANCE * seconds * (1.0 + cos(4.0 * theta))


@compiled_on_views
def rims_after(
    left: float, right: float, left_target: float, right_target: float, seconds: float, force: float, compliance: float
) -> tuple[float, float]:
    """Return the rim speeds after ``seconds``; each motor reaches its target, or pushes with ``force`` at most.

    A motor that is not at its limit misses its target by ``compliance`` for each N of its push: see
    ``solver_compliance``.
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
        left + a * seconds - _missing(push_left, force, compliance),
        right + b * seconds - _missing(push_right, force, compliance),
    )


@compiled_on_views
def _missing(push: float, force: float, compliance: float) -> float:
    """Return the shortfall of the rim speed at this push of the motor; 0 at the limit ``force``."""
    return compliance * (push + LOAD) if abs(push) < 0.999 * force else 0.0


@compiled_on_views
def _pulls_of_turning(left: float, right: float) -> tuple[float, float]:
    """Return the forces at the rims that keep their speeds while the robot turns."""
    v, omega = 0.5 * (left + right), (right - left) / TRACK
    ahead, turn = 0.5 * MOMENT * omega * omega, MOMENT * v * omega / TRACK
    return ahead + turn, ahead - turn


@compiled_on_views
def _limited(push: float, other: float, bias: float, other_bias: float, force: float) -> tuple[float, float]:
    """Return the accelerations of a rim whose motor is at its limit, and of the other rim.

    ``other`` is the acceleration of the other rim if its own motor is below its limit.
    """
    push = min(max(push, -force), force)
    a = (push - bias - CROSS * other) / OWN
    other_push = CROSS * a + OWN * other + other_bias
    if abs(other_push) > force:
        other_push = min(max(other_push, -force), force) - other_bias
        push -= bias
        det = OWN * OWN - CROSS * CROSS
        return (OWN * push - CROSS * other_push) / det, (OWN * other_push - CROSS * push) / det
    return a, other
