"""The simulated world: floor, solids, gravity, time and rays. Metres, seconds, map frame."""

from collections.abc import Callable, Sequence
from functools import partial
from itertools import chain
from operator import itemgetter
from typing import Any, Final

import numpy as np

from sim.bullet import Bullet, pybullet
from sim.mesh import extrude, reused_lists
from sim.ray_casters import ExactCaster, RayCaster
from slam.closing import Closing
from slam.pose import FloatArray
from slam.scenario.lidar_config import CasterName
from slam.scenario.solids import SILL, Prism

GRAVITY: Final = 9.81
"""m/s^2."""
SOLVER_ITERATIONS: Final = 60
"""Solver iterations: with PyBullet's 50 a robot at rest creeps 2 um/s, with 60 less than half of it; each costs 0.3 us
per step."""
RAYS_PER_CALL: Final = 8192
"""Largest number of rays per call: PyBullet silently drops all rays after the first 16,384."""

YIELDING: Final = {"contactStiffness": 2000.0, "contactDamping": 1000.0}
"""Softness of a pillar, N/m and N s/m: a pillar placed inside the robot pushes it gently aside; a hard one flings
it."""

OUT_OF_REACH: Final = (0.0, 0.0, -10.0)
"""x, y, z, metres: a position below the floor, where nothing touches anything."""

FAR_AWAY: Final = (1e4, 1e4, 5.0)
"""x, y, z, metres: a position far from everything."""
FLOOR, WALLS, ROBOT, PEOPLE, SILLS, MOVABLE = 1, 2, 4, 8, 16, 32
"""Collision groups, used in p3dx.urdf too. Rays belong to group 1 and hit walls and sills only."""
COLLIDES_WITH: Final = {FLOOR: ROBOT | MOVABLE, WALLS: ROBOT | MOVABLE | 1, PEOPLE: ROBOT, SILLS: MOVABLE | 1}
"""Groups that collide with each group of static bodies; bodies that overlap each other would cost 1 ms a pair."""

_hit_fraction = itemgetter(2)


class World(Closing):
    """A physics world that steps ``rate`` times a second. Use it as a context manager, or close it."""

    def __init__(self, prisms: Sequence[Prism], rate: int) -> None:
        self.prisms = tuple(prisms)
        self.rate = rate
        self.movables: set[int] = set()
        """Bodies that the robot can push."""
        self.bullet = Bullet()
        self.bullet.call(
            pybullet.setPhysicsEngineParameter,
            fixedTimeStep=1.0 / rate,
            numSolverIterations=SOLVER_ITERATIONS,
            solverResidualThreshold=0.0,
            deterministicOverlappingPairs=1,
            collisionFilterMode=0,  # both masks must agree; the default is that one is enough (bullet3 issue 4148)
        )
        self.step: Callable[[], None] = self.bullet.prepared(pybullet.stepSimulation)
        """Let 1 / rate seconds pass."""
        self.bullet.call(pybullet.setGravity, 0.0, 0.0, -GRAVITY)
        self.floor = self._add_static(FLOOR, lateral_friction=1.0, shapeType=pybullet.GEOM_PLANE)
        sills = [prism for prism in prisms if prism.top <= SILL]
        for group, solids in ((WALLS, [prism for prism in prisms if prism.top > SILL]), (SILLS, sills)):
            if solids:
                vertices, indices = reused_lists(extrude(solids))
                mesh = {"vertices": vertices, "indices": indices, "flags": pybullet.GEOM_FORCE_CONCAVE_TRIMESH}
                self._add_static(group, 0.5, shapeType=pybullet.GEOM_MESH, **mesh)

    def close(self) -> None:
        """Free the physics engine; closing twice is allowed."""
        self.bullet.close()

    @property
    def closed(self) -> bool:
        """True after ``close``."""
        return self.bullet.closed

    def save(self) -> None:
        """Remember the state of all bodies, for ``restore``."""
        self._saved = self.bullet.call(pybullet.saveState)

    def restore(self) -> None:
        """Return to time 0 and the saved state; motors keep their last command."""
        self.bullet.call(pybullet.restoreState, self._saved)

    def add_pillar(self, radius: float, height: float) -> int:
        """Add a cylinder that ``move`` places and the robot can hit; rays pass through it. It starts out of range."""
        pillar = self._add_static(PEOPLE, 0.5, shapeType=pybullet.GEOM_CYLINDER, radius=radius, height=height)
        self.bullet.call(pybullet.changeDynamics, pillar, -1, **YIELDING)
        self.move(pillar, *OUT_OF_REACH)
        return pillar

    def move(self, body: int, x: float, y: float, z: float) -> None:
        """Move the middle of a body there, at once."""
        self.bullet.call(pybullet.resetBasePositionAndOrientation, body, (x, y, z), (0.0, 0.0, 0.0, 1.0))

    def park_far_away(self, body: int, number: int) -> None:
        """Move a body far from everything, including other bodies that were moved away."""
        x, y, z = FAR_AWAY
        self.move(body, x + number * x, y, z)

    def cast(self, origins: FloatArray, ends: FloatArray) -> FloatArray:
        """Return the share (N,) of each ray from ``origins`` to ``ends``, (N, 3), up to the first hit: 0 to 1 or inf.

        Accurate to a micrometre, except at free edges: PyBullet extends triangles by 1e-4 of their height.
        """
        batches = [slice(start, start + RAYS_PER_CALL) for start in range(0, len(ends), RAYS_PER_CALL)]
        test = partial(self.bullet.call, pybullet.rayTestBatch, collisionFilterMask=WALLS | SILLS)
        hits = chain.from_iterable(test(origins[batch], ends[batch]) for batch in batches)
        fractions = np.fromiter(map(_hit_fraction, hits), np.float64, len(ends))
        fractions[fractions == 1.0] = np.inf
        return fractions

    def caster(self, name: CasterName, height: float, reach: float) -> RayCaster:
        """Make the ray caster with this name, for rays at this height and of this length."""
        return ExactCaster(self.prisms, height, reach) if name == "exact" else BulletCaster(self, height, reach)

    def _add_static(self, group: int, lateral_friction: float, **shape: Any) -> int:
        shape_id = self.bullet.call(pybullet.createCollisionShape, **shape)
        body: int = self.bullet.call(pybullet.createMultiBody, 0.0, shape_id)
        self.bullet.call(pybullet.changeDynamics, body, -1, lateralFriction=lateral_friction)
        self.bullet.call(pybullet.setCollisionFilterGroupMask, body, -1, group, COLLIDES_WITH[group])
        return body


class BulletCaster:
    """Casts rays through the mesh of the world; ``height`` and ``reach`` in metres."""

    def __init__(self, world: World, height: float, reach: float) -> None:
        self._world, self._height, self._reach = world, height, reach

    def cast(self, rays: FloatArray) -> FloatArray:
        starts = np.column_stack([rays[0], rays[1], np.full(rays.shape[1], self._height)])
        ends = starts.copy()
        ends[:, :2] += self._reach * rays[2:4].T
        return self._reach * self._world.cast(starts, ends)
