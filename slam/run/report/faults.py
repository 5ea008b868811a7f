"""Faults of a run, as sentences."""

from collections.abc import Iterator, Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from slam.pose import FloatArray, wrap_angles
from slam.run.results.run_record import RunRecord
from slam.run.results.traces import Traces

_GAP: Final = 1.8
"""Number of scan periods without a scan that make a gap."""
_STALLED: Final = 1.0
"""Seconds without motion under a command after which the robot counts as blocked."""
_CREEP: Final = 0.02, 0.05
"""Speeds below which there is no motion, m/s and rad/s; twice that is a command."""
_TOO_LONG: Final = {"duration over", "no more scans"}
"""Endings of a run that had no time to arrive; the second is that of older runs."""
_PHANTOM: Final = 0.10
"""Least length of a mapped wall in free space, in one piece, that is a fault, metres."""
_NAMED: Final = 3
"""Number of times that are listed; the others are counted."""


def faults(record: RunRecord, metrics: Mapping[str, Any]) -> list[str]:
    """Return one sentence for each fault; empty for a run without fault."""
    damage = [f"{damage}; what comes after that is left out." for damage in record.damage]
    return [*damage, *_how_it_ended(record, metrics), *_on_the_way(record.traces)]


def _how_it_ended(record: RunRecord, metrics: Mapping[str, Any]) -> Iterator[str]:
    ending, last = metrics.get("ending"), record.traces.stamps[-1]
    if record.metrics is None:
        yield f"The run did not end: it was killed, or is still going. Its last scan is at {last:.1f} s."
    if record.traces.closed is None and "back_end_lost" in metrics:
        lost = metrics["back_end_lost"]
        yield f"{lost[:1].upper()}{lost[1:]}: the results are those estimated during the run; try hopslam optimize."
    elif record.traces.jumps.any() and record.traces.closed is None:
        yield "Its loops were not closed at the end: the results are those during the run; try hopslam optimize."
    if ending == "collided":
        yield f"The robot hit something at {last:.1f} s."
    if ending == "interrupted":
        yield f"It was interrupted by hand at {last:.1f} s."
    if "error" in metrics:
        what = "stopped" if ending == "battery empty" else "failed"
        yield f"The robot {what}: {metrics['error']}."
    if ending in _TOO_LONG and "log" not in metrics:
        yield f"It did not arrive within the {record.config.duration:g} s of the scenario."
    if metrics.get("wall_phantom_m", 0.0) > _PHANTOM:
        free, longest = metrics["wall_free_air_m"], metrics["wall_phantom_m"]
        yield f"The line map has {free:.1f} m of walls in free air, of which {longest:.1f} m in one piece."


def _on_the_way(traces: Traces) -> Iterator[str]:
    stamps, steps = traces.stamps, traces.steps
    matched = (steps["mapped"] == 1) & (steps["iterations"] > 0)
    stuck = matched & (steps["converged"] == 0)
    yield from _counted("{n} of {all} scans: the robot was lost", steps["lost"] == 1, stamps)
    alone = "{n} of {all} scans: no match could be trusted, and the pose is that of odometry alone"
    yield from _counted(alone, traces.odometry_only, stamps)
    share = f"{{n}} of {int(matched.sum())} matches did not converge within the limit of iterations"
    yield from _counted(share, stuck, stamps)
    period = float(np.median(np.diff(stamps))) if len(stamps) > 1 else 0.0
    gaps = np.append(False, np.diff(stamps) > _GAP * period)
    yield from _counted(f"Gaps of more than {_GAP:g} scan periods of {period:.3g} s: {{n}}", gaps, stamps)
    late = steps["slam_ms"] > 1e3 * period if period else np.zeros(len(stamps), np.bool_)
    yield from _counted(f"{{n}} of {{all}} scans took longer to process than the {1e3 * period:.0f} ms between two",
                        late, stamps)  # fmt: skip
    yield from _counted("{n} of {all} scans: the wheels stood still under a command (stall)", _stalled(traces), stamps)


def _counted(text: str, are: NDArray[np.bool_], stamps: FloatArray) -> Iterator[str]:
    """Yield the sentence if the mask has any scan, with the times of the first ones."""
    if not are.any():
        return
    starts = stamps[are & ~np.append(False, are[:-1])]
    times = ", ".join(f"{stamp:.1f}" for stamp in starts[:_NAMED])
    more = f" and {len(starts) - _NAMED} times more" if len(starts) > _NAMED else ""
    yield f"{text.format(n=int(are.sum()), all=len(stamps))}, from {times} s{more}."


def _stalled(traces: Traces) -> NDArray[np.bool_]:
    """Return the scans at the end of at least one second in which a command moved no wheel."""
    if len(traces.stamps) < 2:
        return np.zeros(len(traces.stamps), np.bool_)
    elapsed = np.diff(traces.stamps)
    moved = np.diff(traces.odometry, axis=0)
    turned = np.abs(wrap_angles(moved[:, 2]))
    still = (np.hypot(moved[:, 0], moved[:, 1]) < _CREEP[0] * elapsed) & (turned < _CREEP[1] * elapsed)
    commanded = (np.abs(traces.steps["v"]) > 2 * _CREEP[0]) | (np.abs(traces.steps["omega"]) > 2 * _CREEP[1])
    since, stalled = 0.0, np.zeros(len(traces.stamps), np.bool_)
    for k in range(len(elapsed)):
        since = since + elapsed[k] if still[k] and commanded[k + 1] else 0.0
        stalled[k + 1] = since >= _STALLED
    return stalled
