"""The clocks of a simulated robot, each dividing the next: physics, control, scan."""

from dataclasses import dataclass
from importlib.util import find_spec
from math import ceil
from typing import Annotated, Literal

from pydantic import Field

from slam.config import Section

Engine = Literal["bullet", "plan"]


def installed_engine() -> Engine:
    """Return PyBullet if it is installed, else the kinematic model."""
    return "bullet" if find_spec("pybullet") else "plan"


class Physics(Section):
    """The engine of the simulation, and its clock."""

    engine: Engine = Field(default_factory=installed_engine)
    """``bullet``: PyBullet, with forces, the default if it is installed. ``plan``: a compiled kinematic model in the
    plan of the world, many times faster; obstacles stop the robot, and it cannot push anything. See
    docs/simulator.md."""
    rate: Annotated[int, Field(ge=60, le=10_000)] = 240
    """Physics steps per second."""


@dataclass(frozen=True, slots=True)
class Clock:
    """A scan period is ``controls_per_scan`` control steps of ``steps_per_control`` physics steps each.

    The beams of a rolling scan fire in the last ``controls_per_sweep`` control steps of the period; 0 means that all
    beams fire at its end.
    """

    rate: int
    """Physics steps per second."""
    steps_per_control: int
    controls_per_scan: int
    controls_per_sweep: int

    @property
    def steps_per_scan(self) -> int:
        """Physics steps from one scan to the next."""
        return self.steps_per_control * self.controls_per_scan

    @property
    def control_period(self) -> float:
        """Seconds from one control step to the next."""
        return self.steps_per_control / self.rate


def make_clock(rate: int, control_rate: int, scan_time: float, sweep: float) -> Clock:
    """Make a clock; ``scan_time``, and the ``sweep`` of its beams, in seconds. ValueError if one is not divisible."""
    if rate % control_rate:
        raise ValueError(
            f"physics.rate = {rate} is not a multiple of robot.control_rate = {control_rate}; "
            f"choose for example physics.rate = {control_rate * max(round(rate / control_rate), 1)}"
        )
    controls = round(control_rate * scan_time)
    if controls < 1 or abs(control_rate * scan_time - controls) > 1e-9:
        raise ValueError(
            f"robot.control_rate = {control_rate} gives {control_rate * scan_time:g} control steps in the "
            f"{scan_time:g} s of a scan; choose a rate that gives a whole number"
        )
    in_sweep = ceil(control_rate * sweep - 1e-9)
    if in_sweep > controls:
        raise ValueError(f"the beams of a scan take {sweep:g} s, longer than the {scan_time:g} s from scan to scan")
    return Clock(rate, rate // control_rate, controls, in_sweep)
