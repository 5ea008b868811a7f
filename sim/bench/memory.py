"""Growth of memory over a long life of a process."""

from dataclasses import dataclass

from sim.robot import SimRobot
from slam.odometry import Twist2D
from slam.scenario.schema import Scenario
from slam.system import peak_memory


@dataclass(frozen=True, slots=True)
class MemoryGrowth:
    """Megabytes by which the most memory that this process ever held has grown on the way."""

    resets: int
    steps: int
    robots: int
    of_one_robot: float
    of_many_robots: float


def memory_growth(scenario: Scenario, resets: int, scans_each: int, robots: int) -> MemoryGrowth:
    """One robot restarted and driven again and again, then so many robots made, driven for a scan and closed.

    The first hundredth of each is not counted: caches fill.
    """
    with SimRobot(scenario, 0) as robot:
        for seed in range(resets):
            if seed == resets // 100:
                begun = peak_memory()
            robot.restart(seed)
            for _ in range(scans_each):
                robot.drive(Twist2D(0.5, 0.1))
                robot.observe()
    one = 1e-6 * (peak_memory() - begun)
    for seed in range(robots):
        if seed == robots // 100:
            begun = peak_memory()
        with SimRobot(scenario, seed) as robot:
            robot.observe()
    many = 1e-6 * (peak_memory() - begun)
    return MemoryGrowth(resets, resets * scans_each * scenario.clock.steps_per_scan, robots, one, many)
