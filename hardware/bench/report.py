"""The tables of ``hopslam bench hardware``."""

from __future__ import annotations

from collections.abc import Iterator

from hardware.bench.bench import bench
from hardware.bench.faults import all_faults
from hardware.bench.load import measure_load
from slam.run.bench.tables import ResultTable


def hardware_tables(seconds: float) -> Iterator[ResultTable]:
    """Load and latency, then faults."""
    with bench() as at:
        load = measure_load(at, seconds)
    yield ResultTable(
        "Drivers and emulator, in real time",
        ("", "value"),
        [
            ("CPU of one core, drivers and emulator together", f"{100.0 * load.cpu:.1f} %"),
            ("scans a second", f"{load.scans / load.seconds:.2f}"),
            ("last beam to observe, median", f"{1e3 * load.latency_median:.1f} ms"),
            ("last beam to observe, p99", f"{1e3 * load.latency_p99:.1f} ms"),
        ],
        f"The corridor at 0.3 m/s for {seconds:g} s, moved by PyBullet, over two pseudo-terminals.",
    )
    rows = [(f.name, _seconds(f.to_stand), _seconds(f.to_drive), f.reason) for f in all_faults()]
    columns = ("fault", "until it stands\ns", "cure to motion\ns", "reason named")
    yield ResultTable("Faults at 0.3 m/s", columns, rows, "The robot's own watchdog is set to 2 s.")


def _seconds(seconds: float | None) -> str:
    return "never" if seconds is None else f"{seconds:.2f}"
