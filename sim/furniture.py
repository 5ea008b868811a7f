"""Furniture that the robot can push: bodies in the simulated world that slide and turn on the floor."""

from collections.abc import Sequence
from math import atan2, cos, hypot, sin, sqrt
from typing import Any, Final

import numpy as np

from sim.bullet import pybullet
from sim.world import FLOOR, GRAVITY, MOVABLE, ROBOT, SILLS, WALLS, World
from slam.pose import FloatArray
from slam.scenario.furniture import Movable
from slam.scenario.solids import SILL, Prism

SLIDING: Final = 0.3
"""Friction of furniture on the floor; wood or felt has 0.2 to 0.5."""
BODY, FOOTING = -1, 0
"""Numbers of the two links: the body that walls and the robot collide with, and the one that stands on the floor."""
FEET: Final = 4
"""Feet of a piece; each carries the same load, because all sink in equally."""
FOOT: Final = 0.01
"""Radius of a foot, a ball, metres."""
SINKING: Final = 1e-4
"""Metres by which the feet sink into the floor under the weight."""
UPRIGHT: Final = 1e9
"""Inertia of furniture about its horizontal axes, kg m^2; so large that it does not tip over."""
ARM_CELLS: Final = 16
"""Number of cells along each side of a triangle of the footprint; the friction arm of a square is exact to 0.1 %."""


class Furniture:
    """Upright bodies that slide and turn on the floor, and never tip over."""

    def __init__(self, world: World, movables: Sequence[Movable]) -> None:
        self._world = world
        self._bodies = [add_movable(world, thing) for thing in movables]
        self._find = [world.bullet.prepared(pybullet.getBasePositionAndOrientation, body) for body in self._bodies]

    def __len__(self) -> int:
        """Number of pieces."""
        return len(self._bodies)

    def park_far_away(self) -> None:
        """Move all pieces far from everything and from each other: see ``P3dx.park_far_away``."""
        for number, body in enumerate(self._bodies):
            self._world.park_far_away(body, number + 1)

    @property
    def places(self) -> FloatArray:
        """Present poses: x, y, theta in the map frame, (M, 3); metres, radians."""
        places = [(x, y, 2.0 * atan2(qz, qw)) for (x, y, _), (_, _, qz, qw) in (find() for find in self._find)]
        return np.array(places, np.float64).reshape(-1, 3)


def add_movable(world: World, thing: Movable) -> int:
    """Add a body that slides on the floor and that rays pass through; its frame is that of the thing.

    It stands on four soft feet that resist sliding and turning as its whole footprint does. Hard contacts of a body
    that cannot tip share its weight at random: often one contact carries all of the weight, and the body turns freely
    about it.
    """
    length, width = np.ptp(np.concatenate([prism.footprint for prism in thing.prisms]), axis=0).tolist()
    (x, y), theta = thing.T_map_thing.translation, thing.T_map_thing.theta
    body: int = world.bullet.call(
        pybullet.createMultiBody,
        thing.mass,
        _compound(world, [_part(prism) for prism in thing.prisms]),
        basePosition=(x, y, 0.0),
        baseOrientation=(0.0, 0.0, sin(theta / 2.0), cos(theta / 2.0)),
        **_fixed_link(_compound(world, _feet(length, width, friction_arm(thing.prisms)))),
    )
    inertia = UPRIGHT, UPRIGHT, thing.mass * (length**2 + width**2) / 12.0  # middle of the bounding box
    stiffness = thing.mass * GRAVITY / (FEET * SINKING)
    damping = sqrt(stiffness * thing.mass)  # critical damping for a quarter of the mass
    met = WALLS | SILLS | MOVABLE | (ROBOT if max(prism.top for prism in thing.prisms) > SILL else 0)
    for part, meets, dynamics in (
        (BODY, met, {"localInertiaDiagonal": inertia}),
        (FOOTING, FLOOR, {"contactStiffness": stiffness, "contactDamping": damping}),
    ):
        world.bullet.call(pybullet.changeDynamics, body, part, lateralFriction=SLIDING, **dynamics)
        world.bullet.call(pybullet.setCollisionFilterGroupMask, body, part, MOVABLE, meets)
    world.movables.add(body)
    return body


def _compound(world: World, parts: Sequence[dict[str, Any]]) -> Any:
    """One shape made of several parts."""
    arguments = {name: [part[name] for part in parts] for name in parts[0]}
    return world.bullet.call(pybullet.createCollisionShapeArray, **arguments)


def _fixed_link(shape: int) -> dict[str, Any]:
    """Return the PyBullet arguments of a massless part, which collides with other things than the base does."""
    origin, upright = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)
    return {
        "linkMasses": [0.0],
        "linkCollisionShapeIndices": [shape],
        "linkVisualShapeIndices": [-1],
        "linkPositions": [origin],
        "linkOrientations": [upright],
        "linkInertialFramePositions": [origin],
        "linkInertialFrameOrientations": [upright],
        "linkParentIndices": [0],
        "linkJointTypes": [pybullet.JOINT_FIXED],
        "linkJointAxis": [(0.0, 0.0, 1.0)],
    }


def _feet(length: float, width: float, arm: float) -> list[dict[str, Any]]:
    """Return four balls on the diagonals of the outline, ``arm`` metres from its middle."""
    x, y = arm * length / hypot(length, width), arm * width / hypot(length, width)
    return [
        {"shapeTypes": pybullet.GEOM_SPHERE, "radii": FOOT, "collisionFramePositions": (sx * x, sy * y, FOOT)}
        for sx, sy in ((-1, -1), (1, -1), (1, 1), (-1, 1))
    ]


def _part(prism: Prism) -> dict[str, Any]:
    """Return the PyBullet arguments of a part: a box along the axes of its frame, or a cylinder."""
    middle, height = prism.footprint.mean(axis=0), prism.top - prism.bottom
    length, width = np.ptp(prism.footprint, axis=0)
    return {
        "shapeTypes": pybullet.GEOM_BOX if len(prism.footprint) == 4 else pybullet.GEOM_CYLINDER,
        "halfExtents": (length / 2.0, width / 2.0, height / 2.0),
        "radii": length / 2.0,
        "lengths": height,
        "collisionFramePositions": (*middle, prism.bottom + height / 2.0),
    }


def friction_arm(prisms: Sequence[Prism]) -> float:
    """Return the mean distance of the footprint from the origin, metres.

    The moment that resists turning about the origin is this distance times the sliding friction, if the pressure is
    uniform. The distance is 2 R / 3 for a disc, and L / 4 for a thin rod.
    """
    bottom = min(prism.bottom for prism in prisms)
    moments = np.sum([_moments(prism.footprint) for prism in prisms if prism.bottom == bottom], axis=0)
    return float(moments[1] / moments[0])


def _moments(footprint: FloatArray) -> FloatArray:
    """Return the area of a convex polygon (N, 2), and the integral over it of the distance from the origin.

    The sum is over triangles between the middle and the edges, each cut into ARM_CELLS x ARM_CELLS cells.
    """
    shares = (np.arange(ARM_CELLS) + 0.5) / ARM_CELLS
    middle = footprint.mean(axis=0)
    here, there = footprint - middle, np.roll(footprint, -1, axis=0) - middle
    doubled = here[:, 0] * there[:, 1] - here[:, 1] * there[:, 0]
    edges = here[:, None] + shares[:, None] * (there - here)[:, None]  # (N, ARM_CELLS, 2)
    points = middle + shares[:, None] * edges[:, :, None]  # (N, ARM_CELLS, ARM_CELLS, 2)
    areas = doubled[:, None, None] * shares / ARM_CELLS**2
    return np.array([areas.sum() * ARM_CELLS, (areas * np.hypot(points[..., 0], points[..., 1])).sum()])
