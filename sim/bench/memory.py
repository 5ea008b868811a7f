"""Growth of memory over a long life of a process."""

from dataclasses import dataclass

from sim.robot import SimRobot
from slam.odometry import Twist2D
from slam.scenario.schema import Scenario
from slam.system import peak_memory


@dataclass(frozen=True, slots=True)
class MemoryGrowth:
    """Growth of the process's peak memory during a measurement, megabytes."""

    resets: int
    steps: int
    robots: int
    of_one_robot: float
    of_many_robots: float


def memory_growth(scenario: Scenario, resets: int, scans_each: int, robots: int) -> MemoryGrowth:
    """Measure the memory of one robot restarted and driven many times, and of many robots made and closed.

    The first hundredth of each is not counted, as caches fill.
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
