"""A planar lidar in the simulated world: the Hokuyo URG-04LX, or any other ``LidarModel``."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sim.gait import LEG_HEIGHT
from sim.lidar_noise import measure
from sim.moving_outlines import MovingOutlines
from sim.ray_casters import RayCaster, Surroundings
from sim.rays import ScanMotion, fire_beams
from sim.z_buffer import stop_at_legs
from slam.lidars import Lidar
from slam.pose import FloatArray, unit_vectors
from slam.scan import LaserScan
from slam.scenario.furniture import Movable
from slam.scenario.lidar_config import LidarConfig


class SimulatedLidar:
    """Measures the beams of a scan one after another, or all at once, in a plane ``config.height`` metres up.

    ``leg_radii`` (L,) are the radii of the legs of people, metres; ``movables`` is the furniture that can move.
    """

    def __init__(
        self,
        surroundings: Surroundings,
        config: LidarConfig,
        leg_radii: FloatArray | None = None,
        movables: Sequence[Movable] = (),
    ) -> None:
        model = config.description
        lidar = model.lidar
        self._config = config
        self._lidar, self._beams_vary, self._increment = lidar, model.beams_vary, config.time_increment
        self._mount = config.mount.pose.translation
        self._bearings = config.mount.theta + lidar.angles
        self._beams = _beams_at(self._bearings)
        self._leg_radii = np.empty(0) if leg_radii is None or config.height > LEG_HEIGHT else leg_radii
        self._outlines = MovingOutlines(movables, config.height)
        self._reach = float(lidar.range_max + model.accuracy(np.array(lidar.range_max)))  # noise may shorten it
        self.caster: RayCaster = surroundings.caster(config.caster, config.height, self._reach)

    def scan(self, motion: ScanMotion, stamp: float, rng: np.random.Generator) -> LaserScan:
        """Take one scan; its first beam fires at ``stamp``, and the noise comes from ``rng``."""
        lidar, increment, bearings, beams = self._lidar, self._increment, self._bearings, self._beams
        if self._beams_vary:
            lidar = self._turn(rng)
            increment = increment * lidar.angle_increment / self._lidar.angle_increment
            bearings = self._config.mount.theta + lidar.angles
            beams = _beams_at(bearings)
        return LaserScan(
            stamp=stamp,
            angle_min=lidar.angle_min,
            angle_increment=lidar.angle_increment,
            range_min=lidar.range_min,
            range_max=lidar.range_max,
            ranges=measure(self._cast(motion, bearings, beams, increment), stamp, self._config, rng),
            time_increment=increment,
            scan_time=lidar.scan_time,
        )

    def _turn(self, rng: np.random.Generator) -> Lidar:
        """Return the fan of the next turn of a motor that does not hold its speed.

        Its first beam lies anywhere in the first step, and the number of beams varies with the speed.
        """
        nominal, vary = self._lidar, self._beams_vary
        beams = nominal.beams + int(rng.integers(-vary, vary + 1))
        step = nominal.angle_increment * nominal.beams / beams
        return replace(nominal, angle_min=nominal.angle_min + step * rng.random(), angle_increment=step, beams=beams)

    def measure_beams(
        self, bearings: FloatArray, motion: ScanMotion, increment: float, time: float, rng: np.random.Generator
    ) -> FloatArray:
        """Measure single beams at ``bearings`` (N,) of the lidar's own frame, ``increment`` seconds apart, with noise.

        ``motion`` is the motion during the scan, and ``time`` the seconds since the start.
        """
        bearings = self._config.mount.theta + bearings
        ranges = self._cast(motion, bearings, _beams_at(bearings), increment)
        return measure(ranges, time, self._config, rng)

    def true_ranges(self, motion: ScanMotion) -> FloatArray:
        """Return the distance along each beam to the first surface, metres, (beams,); inf if nothing is in range."""
        return self._cast(motion, self._bearings, self._beams, self._increment)

    def _cast(self, motion: ScanMotion, bearings: FloatArray, beams: FloatArray, increment: float) -> FloatArray:
        rays = np.empty((5, len(bearings)))
        fire_beams(motion.path, motion.step, self._mount, bearings, beams, increment, rays)
        ranges = self.caster.cast(rays)
        if len(self._outlines) or len(self._leg_radii):
            rows = increment / motion.step  # from one beam to the next
            self._outlines.stop(rays, ranges, motion.things, rows)
            stop_at_legs(rays, ranges, motion.legs, self._leg_radii, rows)
            ranges[ranges > self._reach] = np.inf
        return ranges


def _beams_at(bearings: FloatArray) -> FloatArray:
    """Return unit vectors (2, N), row by row."""
    return np.ascontiguousarray(unit_vectors(bearings).T)
