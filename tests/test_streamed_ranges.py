"""Ranges read from the file on demand: the same rows in any order, and constant memory."""

import pickle
import tracemalloc
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slam.errors import LogError
from slam.files.logs import read, read_log
from slam.files.logs.streamed_ranges import StreamedRanges, at_places
from slam.files.ros.encoder import Encoder
from slam.files.ros.mcap_files import McapWriter
from slam.pose import FloatArray
from slam.scan import LaserScan

BEAMS = [3, 5, 4] * 20
FEW, MANY, WIDE = 20, 60, 1000


class Source:
    """Rows, and how often they were read from the beginning."""

    def __init__(self) -> None:
        self.passes = 0

    def rows(self) -> Iterator[FloatArray]:
        self.passes += 1
        return (np.full(beams, float(index)) for index, beams in enumerate(BEAMS))


@given(st.lists(st.integers(0, len(BEAMS) - 1), max_size=10))
def test_rows_are_the_same_in_any_order(order: list[int]) -> None:
    ranges = StreamedRanges(Path("log"), Source().rows, BEAMS)
    for index in order:
        np.testing.assert_array_equal(ranges[index], np.full(BEAMS[index], index))


def test_short_steps_back_read_the_file_once() -> None:
    source = Source()
    ranges = StreamedRanges(Path("log"), source.rows, BEAMS)
    for index in range(len(ranges)):
        assert ranges[index][0] + ranges[max(index - 10, 0)][0] == index + max(index - 10, 0)
    assert source.passes == 1


def test_the_whole_array_has_short_rows_filled_with_nan() -> None:
    whole = np.asarray(StreamedRanges(Path("log"), Source().rows, BEAMS))
    assert whole.shape == (60, 5)
    assert np.isfinite(whole).sum(axis=1).tolist() == BEAMS


def test_a_log_that_is_being_read_goes_to_another_process(small_log: Path) -> None:
    log = read_log(small_log)
    log.scan(1)
    copy = pickle.loads(pickle.dumps(log))
    np.testing.assert_array_equal(copy.scan(2).ranges, log.scan(2).ranges)


def test_rows_are_read_only() -> None:
    with pytest.raises(ValueError, match="read-only"):
        StreamedRanges(Path("log"), Source().rows, BEAMS)[0][0] = 1.0


@given(st.sets(st.integers(1, 30)))
def test_parts_at_given_indices_are_those_rows(places: set[int]) -> None:
    assert list(at_places(enumerate(range(1, 31), 1), sorted(places))) == sorted(places)


@pytest.mark.parametrize("change", ["cut", "removed", "other"])
def test_a_log_that_changes_under_a_replay_is_named(small_log: Path, change: str) -> None:
    log = read_log(small_log)
    text = small_log.read_bytes()
    if change == "removed":
        small_log.unlink()
    else:
        small_log.write_bytes(text[: len(text) // 2] if change == "cut" else text.replace(b"ROBOTLASER1", b"FLASER"))
    with pytest.raises(LogError, match=small_log.name):
        np.asarray(log.ranges)


def wide_carmen(path: Path, scans: int) -> Path:
    readings = np.random.default_rng(0).uniform(1.0, 9.0, WIDE)
    lines = [
        f"FLASER {WIDE} {' '.join(f'{r:.3f}' for r in np.roll(readings, k))} 0 0 0 0 0 0 {k / 10} h {k / 10}"
        for k in range(scans)
    ]
    path.write_text("\n".join(lines))
    return path


def wide_mcap(path: Path, scans: int) -> Path:
    encoder, readings = Encoder(), np.random.default_rng(0).uniform(1.0, 9.0, WIDE)
    writer = McapWriter(path, encoder, 1 << 16)
    for k in range(scans):
        scan = LaserScan(k / 10, -1.5, 3e-3, 0.1, 10.0, np.roll(readings, k), 0.0, 0.1)
        writer.write("/scan", 10**8 * k, encoder.scan(scan))
    writer.close()
    return path


@pytest.mark.parametrize("write", [wide_carmen, wide_mcap])
def test_memory_does_not_grow_with_the_ranges(
    write: Callable[[Path, int], Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(read, "_HEAD", 5)  # lines that are kept until the format is known
    few, many = (write(tmp_path / f"{scans}.log", scans) for scans in (FEW, MANY))
    read_log(few)
    peaks = []
    for path in (few, many):
        tracemalloc.start()
        log = read_log(path)
        assert sum(len(log.scan(index).ranges) for index in range(len(log))) == WIDE * len(log)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] - peaks[0] < 3 * (MANY - FEW) * WIDE  # ranges take 8 bytes a beam
