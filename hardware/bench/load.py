"""Benchmark of load: the processor time of drivers and emulator, and the age of a scan when it is seen."""

from __future__ import annotations

from dataclasses import dataclass
from time import monotonic, process_time

import numpy as np

from hardware.bench.emulated_robot import EmulatedRobot
from slam.robot import Observation


@dataclass(frozen=True, slots=True)
class Load:
    """The load of drivers, emulator and physics: ``cpu`` is a share of one core, latencies are seconds."""

    cpu: float
    scans: int
    seconds: float
    latency_median: float
    latency_p99: float


def measure_load(emulated: EmulatedRobot, seconds: float) -> Load:
    """Measure the load while driving for so long."""
    emulated.drive_until(lambda: not emulated.standing)
    began, busy = monotonic(), process_time()
    latencies = []
    while monotonic() - began < seconds:
        observation = emulated.step()
        if observation is not None:
            latencies.append(_latency(observation, emulated.robot.epoch or 0.0))
    cpu = (process_time() - busy) / (monotonic() - began)
    return Load(cpu, len(latencies), seconds, float(np.median(latencies)), float(np.quantile(latencies, 0.99)))


def _latency(observation: Observation, epoch: float) -> float:
    """Return the seconds from the last beam until now."""
    scan = observation.scan
    return monotonic() - (epoch + scan.stamp + (len(scan.ranges) - 1) * scan.time_increment)
