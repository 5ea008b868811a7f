"""What the drivers and the emulator cost, and how old a scan is when it is seen."""

from __future__ import annotations

from dataclasses import dataclass
from time import monotonic, process_time

import numpy as np

from hardware.bench.bench import Bench
from slam.robot import Observation


@dataclass(frozen=True, slots=True)
class Load:
    """``cpu`` is a share of one core, of drivers, emulator and physics together; latencies are seconds."""

    cpu: float
    scans: int
    seconds: float
    latency_median: float
    latency_p99: float


def measure_load(at: Bench, seconds: float) -> Load:
    """Drive for so long."""
    at.drive_until(lambda: not at.standing)
    began, busy = monotonic(), process_time()
    latencies = []
    while monotonic() - began < seconds:
        observation = at.step()
        if observation is not None:
            latencies.append(_latency(observation, at.robot.epoch or 0.0))
    cpu = (process_time() - busy) / (monotonic() - began)
    return Load(cpu, len(latencies), seconds, float(np.median(latencies)), float(np.quantile(latencies, 0.99)))


def _latency(observation: Observation, epoch: float) -> float:
    """From the last beam until now."""
    scan = observation.scan
    return monotonic() - (epoch + scan.stamp + (len(scan.ranges) - 1) * scan.time_increment)
