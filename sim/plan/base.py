"""The base of a P3-DX in the plane, compiled: how far its motors move it in one control step, and what it meets.

``base`` is a record of the type BASE, ``model`` one of the type MODEL: sim/records.py. SI units, radians.
"""

from math import cos, sin
from typing import Any, Final

import numpy as np

from sim.bumpers import TOUCH, bumper_segment
from sim.dead_reckoning import Noise, reckon
from sim.firmware import DRAG_TORQUE, MOTOR_TORQUE, STANDING, switch_on, update_stall_protection, wheel_speeds
from sim.plan.footprint import deepest_overlap
from sim.plan.motors import rims_after, solver_compliance
from sim.random_stream import normal
from sim.wall_plan import WallPlan, cell_near
from sim.wheels import TRACK, WHEEL_RADIUS
from slam.compiled import compiled_on_views, wrapped
from slam.pose import FloatArray

HALVINGS: Final = 5
"""Halvings of a control step that ends in a wall: the robot stops within 1/32 of the step before the wall."""


@compiled_on_views
def put_down(base: Any, x: float, y: float, theta: float, stream: np.uint64) -> None:
    """Place the robot at a pose, as if just switched on."""
    switch_on(base)
    base.x, base.y, base.theta, base.stream = x, y, theta, stream
    base.collided = base.bumpers = 0


@compiled_on_views
def move(base: Any, model: Any, obstacles: WallPlan, world: int, legs: FloatArray, radii: FloatArray) -> None:
    """Run one control step with the motors at the setpoint, then read the encoders and update the odometry.

    A motion that would end deeper in a wall or a leg than it begins is made in part; for the rest of the step the
    wheels are at rest, or spin if the floor is too slippery to stall them.
    """
    left, right = wheel_speeds(base, model)
    rolled_left, rolled_right = _roll(base, model, WHEEL_RADIUS * left, WHEEL_RADIUS * right)
    moved = _drive(base, model, rolled_left, rolled_right, obstacles, world, legs, radii)
    turned = 1.0 if model.wheels_spin else moved
    base.rim_left *= turned
    base.rim_right *= turned
    base.left += turned * rolled_left / WHEEL_RADIUS
    base.right += turned * rolled_right / WHEEL_RADIUS
    stands = abs(base.rim_left) <= STANDING and abs(base.rim_right) <= STANDING
    update_stall_protection(base, model, moved < 1.0 and stands)
    reckon(base, model, _noise(base, model))


@compiled_on_views
def _roll(base: Any, model: Any, left: float, right: float) -> tuple[float, float]:
    """Let the motors approach these rim speeds over the physics steps; return the metres that the rims roll."""
    force = (MOTOR_TORQUE if base.off_steps == 0 else DRAG_TORQUE) / WHEEL_RADIUS
    stands = base.v == 0.0 and base.omega == 0.0  # where PyBullet's robot creeps by 1 um/s, this one does not
    compliance = 0.0 if stands else solver_compliance(base.theta, model.substep)
    rolled_left = rolled_right = 0.0
    for _ in range(model.substeps):
        base.rim_left, base.rim_right = rims_after(
            base.rim_left, base.rim_right, left, right, model.substep, force, compliance
        )
        rolled_left += base.rim_left * model.substep
        rolled_right += base.rim_right * model.substep
    return rolled_left, rolled_right


@compiled_on_views
def arc(x: float, y: float, theta: float, ahead: float, turn: float) -> tuple[float, float, float]:
    """Return the pose after an arc, ``ahead`` metres long, with ``turn`` radians, as ``Twist2D.motion``."""
    half = 0.5 * turn
    chord = ahead * (sin(half) / half if abs(half) > 1e-8 else 1.0)
    return x + chord * cos(theta + half), y + chord * sin(theta + half), wrapped(theta + turn)


@compiled_on_views
def _drive(
    base: Any, model: Any, left: float, right: float,
    obstacles: WallPlan, world: int, legs: FloatArray, radii: FloatArray,
) -> float:  # fmt: skip
    """Move until something is in the way, and record the bumper contacts there; return the share of the motion made."""
    cell = cell_near(obstacles, world, base.x, base.y, 0.0)
    x, y, theta = _moved(base, model, left, right)
    found = deepest_overlap(x, y, theta, obstacles, cell, legs, radii)
    share = 1.0
    if found.depth > 0.0:
        allowed = max(deepest_overlap(base.x, base.y, base.theta, obstacles, cell, legs, radii).depth, 0.0)
        if found.depth > allowed:
            share = 0.0
            for k in range(HALVINGS):
                trial = share + 0.5 ** (k + 1)
                x, y, theta = _moved(base, model, trial * left, trial * right)
                if deepest_overlap(x, y, theta, obstacles, cell, legs, radii).depth <= allowed:
                    share = trial
            x, y, theta = _moved(base, model, share * left, share * right)
    base.x, base.y, base.theta = x, y, theta
    if found.depth > -TOUCH:
        base.collided = 1
        segment = bumper_segment(found.x, found.y)
        if segment >= 0:
            base.bumpers |= 1 << segment
    return share


@compiled_on_views
def _moved(base: Any, model: Any, left: float, right: float) -> tuple[float, float, float]:
    """Return the pose after the wheels without error have rolled these distances.

    In PyBullet each physics step moves along the heading at its start. On average this heading lags behind that of the
    arc by half of the turn in one step.
    """
    turn = (right - left) / TRACK
    behind = 0.5 * turn / model.substeps
    x, y, theta = arc(base.x, base.y, base.theta - behind, 0.5 * (left + right), turn)
    return x, y, wrapped(theta + behind)


@compiled_on_views
def _noise(base: Any, model: Any) -> Noise:
    """Draw the random numbers for the errors of the wheels; 0 without such errors."""
    left, right = (normal(base), normal(base)) if model.encoder_noise > 0.0 else (0.0, 0.0)
    left_slip, right_slip = (normal(base), normal(base)) if model.travel_noise > 0.0 else (0.0, 0.0)
    return left, right, left_slip, right_slip
