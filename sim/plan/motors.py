"""The two motors of the P3-DX, which turn its wheels at the commanded speeds within their torque. SI units.

The centre of mass is d behind the axle, m is the mass, I the inertia about the middle of the axle, b the track. Rims
that push with F_l and F_r give

    F_l + F_r = m (dv/dt + d omega^2),    (F_r - F_l) b / 2 = I d omega/dt - m d v omega.
"""

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

GIVE: Final = 2.5e-5 * WHEEL_RADIUS
"""Rim speed that PyBullet's solver misses for each N with which turning loads this rim, m/s; measured."""
OTHER_GIVE: Final = 1.35e-5 * WHEEL_RADIUS
"""Rim speed that it misses for each N at the other rim, m/s; measured."""


@compiled_on_views
def rims_after(
    left: float, right: float, left_target: float, right_target: float, seconds: float, force: float
) -> tuple[float, float]:
    """Return the rim speeds after ``seconds``; each motor reaches its target, or pushes with ``force`` at most."""
    bias_left, bias_right = _pulls_of_turning(left, right)
    a, b = (left_target - left) / seconds, (right_target - right) / seconds
    push, other_push = OWN * a + CROSS * b + bias_left, CROSS * a + OWN * b + bias_right
    if abs(push) <= force and abs(other_push) <= force:
        return left_target, right_target
    if abs(push) >= abs(other_push):
        a, b = _limited(push, b, bias_left, bias_right, force)
    else:
        b, a = _limited(other_push, a, bias_right, bias_left, force)
    return left + a * seconds, right + b * seconds


@compiled_on_views
def missing_speeds(left: float, right: float) -> tuple[float, float]:
    """Return the speeds that PyBullet's solver misses at rims with these speeds."""
    pull_left, pull_right = _pulls_of_turning(left, right)
    return GIVE * pull_left + OTHER_GIVE * pull_right, GIVE * pull_right + OTHER_GIVE * pull_left


@compiled_on_views
def _pulls_of_turning(left: float, right: float) -> tuple[float, float]:
    """Return the forces at the rims that keep their speeds while the robot turns."""
    v, omega = 0.5 * (left + right), (right - left) / TRACK
    ahead, turn = 0.5 * MOMENT * omega * omega, MOMENT * v * omega / TRACK
    return ahead + turn, ahead - turn


@compiled_on_views
def _limited(push: float, other: float, bias: float, other_bias: float, force: float) -> tuple[float, float]:
    """Return the accelerations of a rim whose motor is at its limit, and of the other, which is ``other``."""
    push = min(max(push, -force), force)
    a = (push - bias - CROSS * other) / OWN
    other_push = CROSS * a + OWN * other + other_bias
    if abs(other_push) > force:
        other_push = min(max(other_push, -force), force) - other_bias
        push -= bias
        det = OWN * OWN - CROSS * CROSS
        return (OWN * push - CROSS * other_push) / det, (OWN * other_push - CROSS * push) / det
    return a, other
