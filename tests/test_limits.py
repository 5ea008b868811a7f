"""Declared limits: each is documented, named in its error, and checked before memory is used."""

import bz2
import gzip
import shutil
import struct
import tracemalloc
from dataclasses import replace
from pathlib import Path

import lz4.frame
import numpy as np
import pytest
import zstandard
from mcap.writer import CompressionType, Writer
from PIL import Image

from slam.errors import InputError, LogError, ScenarioError
from slam.files import tum, unpacking
from slam.files.json_files import read_json
from slam.files.logs import read_log, read_statistics
from slam.files.logs.outliers import outliers
from slam.files.ros.encoder import Encoder
from slam.files.ros.mcap_files import McapWriter
from slam.files.tum import read_tum
from slam.files.unpacking import TooMuch, Unpacker
from slam.limits import BEAMS, CHUNK, FROM_START, LIMITS, MAP_CELLS, PIXELS, SCANS, YAML_DEPTH, YAML_NODES, Limit, table
from slam.mapping.surfel_grid import empty_grid, with_room
from slam.run.results import step_table
from slam.run.results.run_record import RunRecord
from slam.scan import LaserScan
from slam.scenario.file import load_scenario
from slam.scenario.settings import parse_setting
from slam.sweep.make_plan import make_plan
from tests.fuzz_seeds import MAGIC, READERS, messages, record, run_folder

PAGE = Path(__file__).parents[1] / "docs/limits.md"
MANY = 66 << 20
PACK = {"bz2": bz2.compress, "gzip": gzip.compress, "lz4": lz4.frame.compress, "zstd": zstandard.compress}


@pytest.fixture(scope="module")
def zeros() -> dict[str, bytes]:
    """Many zeros, packed in each way."""
    return {name: pack(bytes(MANY)) for name, pack in PACK.items()}


def test_the_page_has_the_table_of_the_module() -> None:
    assert table() in PAGE.read_text()


def test_every_limit_has_its_reason_and_names_it() -> None:
    for limit in LIMITS.values():
        assert limit.excess(limit.most) is None
        assert limit.excess(limit.most + 1, "there") is not None
        assert f"over the limit of {limit.most:,}: {limit.reason}" in str(limit.excess(2 * limit.most))


@pytest.mark.parametrize("packing", PACK)
def test_a_compression_bomb_is_refused_before_it_is_in_memory(packing: str, zeros: dict[str, bytes]) -> None:
    tracemalloc.start()
    with pytest.raises(TooMuch, match=r"unpacks to .* over the limit of"):
        Unpacker().chunk(packing, zeros[packing])
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 4 * CHUNK.most


@pytest.mark.parametrize("packing", PACK)
def test_archives_within_the_limits_are_unpacked(packing: str) -> None:
    unpacker, data = Unpacker(), np.random.default_rng(0).bytes(100_000)
    assert [unpacker.chunk(packing, PACK[packing](data)) for _ in range(3)] == [data] * 3


def test_many_small_bombs_together_are_refused() -> None:
    unpacker, chunk = Unpacker(), bz2.compress(bytes(4 << 20))
    sizes = [len(unpacker.chunk("bz2", chunk)) for _ in range(16)]
    assert sum(sizes) == 64 << 20
    with pytest.raises(TooMuch, match="times the packed size"):
        unpacker.chunk("bz2", chunk)


def test_a_bag_that_unpacks_to_gigabytes_names_the_limit(tmp_path: Path, zeros: dict[str, bytes]) -> None:
    chunk = record(zeros["bz2"], op=b"\x05", compression=b"bz2", size=struct.pack("<I", MANY))
    (tmp_path / "a.bag").write_bytes(MAGIC + record(b" " * 100, op=b"\x03") + chunk)
    with pytest.raises(LogError, match=r"no scan .* unpacks to .* over the limit of .*docs/limits\.md"):
        read_log(tmp_path / "a.bag")


def test_an_mcap_file_that_unpacks_to_gigabytes_names_the_limit(tmp_path: Path) -> None:
    with (tmp_path / "a.mcap").open("wb") as file:
        writer = Writer(file, chunk_size=2 * MANY, compression=CompressionType.ZSTD)
        writer.start("ros2", "test")
        channel = writer.register_channel("/scan", "cdr", 0)
        writer.add_message(channel, 0, bytes(MANY), 0)
        writer.finish()
    with pytest.raises(LogError, match=r"unpacks to .* over the limit of"):
        read_log(tmp_path / "a.mcap")


def test_a_gzip_bomb_of_text_ends_at_the_limit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(unpacking, "UNPACKED_AT_ONCE", Limit(1_000, "bytes", "so says this test"))
    monkeypatch.setattr(unpacking, "UNPACKED_PER_BYTE", Limit(10, "times the packed size", "so says this test"))
    (tmp_path / "a.log.gz").write_bytes(gzip.compress(b"# CARMEN\nSYNC x\n" * 10_000))
    with pytest.raises(LogError, match="read no further: unpacks to"):
        read_log(tmp_path / "a.log.gz")


def test_aliases_for_billions_are_counted_not_expanded(tmp_path: Path) -> None:
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 9)}]" for k in range(1, 12)]
    (tmp_path / "a.yaml").write_text("\n".join(lines))
    with pytest.raises(ScenarioError, match=rf"over the limit of {YAML_NODES.most:,}"):
        load_scenario(tmp_path / "a.yaml")


@pytest.mark.parametrize(
    "text",
    [
        "a: " + "[" * 200 + "]" * 200,
        "a: " + "[" * 9_000,
        "a: &a [*a]",
        "a: 1" + ":1" * 5_000,
        "a: " + "9" * 5_000,
        "a: &a {x: [1, 2, 3, 4, 5]}\nb: &b {<<: [" + "*a, " * 200 + "*a]}\nc: {<<: [" + "*b, " * 200 + "*b]}\n",
    ],
    ids=["deep", "open", "endless", "sexagesimal", "digits", "merged"],
)
def test_yaml_bombs_are_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "a.yaml").write_text(text)
    with pytest.raises(ScenarioError, match=r"limit|closed"):
        load_scenario(tmp_path / "a.yaml")


def test_settings_are_checked_against_the_limits() -> None:
    with pytest.raises(ScenarioError, match=f"over the limit of {YAML_DEPTH.most}"):
        parse_setting("a=" + "[" * 100 + "]" * 100)


@pytest.mark.parametrize(
    "changes",
    [
        {"seeds": "0:1000000000"},
        {"grid": {f"slam.lines.a{k}": list(range(10)) for k in range(9)}},
        {"seeds": "0:900000", "modes": ["hopslam", "paper"]},
    ],
    ids=["seeds", "grid", "both"],
)
def test_runs_of_a_sweep_are_counted_before_they_are_made(changes: dict[str, object]) -> None:
    with pytest.raises(ScenarioError, match=r"(runs|cases) of a sweep, over the limit of"):
        make_plan("corridor", changes)


@pytest.mark.parametrize("name", ["map.pgm", "map.png"])
def test_a_picture_is_refused_by_its_header(tmp_path: Path, name: str) -> None:
    if name.endswith("pgm"):
        (tmp_path / name).write_bytes(b"P5 900000 900000 255\n")
    else:
        Image.new("1", (6_000, 6_000)).save(tmp_path / name)
    (tmp_path / "map.yaml").write_text(f"{{image: {name}, resolution: 0.05, origin: [0, 0, 0]}}")
    with pytest.raises(ScenarioError, match=rf"pixels, over the limit of {PIXELS.most:,}|not an image"):
        load_scenario("corridor", [f"world.map={{file: {tmp_path / 'map.yaml'}}}"])


@pytest.mark.parametrize("text", ["[" * 100_000, '{"a": NaN}', "\xff", ""])
def test_invalid_json_is_an_error_of_one_line(tmp_path: Path, text: str) -> None:
    (tmp_path / "a.json").write_text(text, encoding="latin-1")
    with pytest.raises(InputError, match=r"a\.json: cannot be read: .*; remedy"):
        read_json(tmp_path / "a.json", "remedy")


def test_a_map_does_not_grow_beyond_its_limit() -> None:
    far = np.array([10_000_000, 0])
    with pytest.raises(InputError, match=f"cells of 0.2 m in the map, over the limit of {MAP_CELLS.most:,}"):
        with_room(empty_grid(0.2), far, far, 1)


@pytest.mark.parametrize("out", [[3], [0], [0, 1], [3, 4, 7], []])
def test_outliers_are_poses_from_which_the_path_returns(out: list[int]) -> None:
    stamps = 0.1 * np.arange(20)
    positions = np.column_stack([0.05 * np.arange(20), np.zeros(20)])
    positions[out] += 5_000.0
    assert np.flatnonzero(outliers(stamps, positions)).tolist() == out


@pytest.mark.parametrize("period", [0.1, 1.0, 3.0, 20.0])
def test_a_jump_that_stays_is_no_outlier_at_any_rate(period: float) -> None:
    """After some time the robot could have driven back to where it was, but it did not jump back."""
    stamps, positions = period * np.arange(40), np.zeros((40, 2))
    positions[20:, 0] = 30.0 + 15.0 * period
    assert not outliers(stamps, positions).any()


def test_a_jump_that_stays_is_no_outlier() -> None:
    positions = np.where(np.arange(20) < 12, 0.0, 50.0)[:, None] * [1.0, 1.0]
    assert not outliers(0.1 * np.arange(20), positions).any()


def test_a_pose_beyond_any_distance_is_an_outlier() -> None:
    positions = np.where(np.arange(20) < 12, 0.0, 2.0 * FROM_START.most)[:, None] * [1.0, 0.0]
    assert np.flatnonzero(outliers(0.1 * np.arange(20), positions)).tolist() == list(range(12, 20))


def test_an_outlying_pose_of_a_log_is_skipped_and_named(small_log: Path) -> None:
    lines = small_log.read_text().splitlines()
    lines[4] = lines[4].replace(" 0.200 0 0 0.200 0 0 ", " 0.200 0 0 1e7 0 0 ")
    small_log.write_text("\n".join(lines))
    log = read_log(small_log)
    assert len(log) == 11
    assert "1 outlying pose" in log.report
    assert "10,000,000 metres from the start, over the limit of 100,000" in log.report
    assert np.abs(log.T_odom_base).max() < 1.0


def test_a_text_scan_of_too_many_beams_is_skipped_and_named(small_log: Path) -> None:
    beams = BEAMS.most + 1
    with small_log.open("a") as file:
        file.write(f"FLASER {beams} {'1 ' * beams}0 0 0 0 0 0 99.0 h 99.0\n")
    log = read_log(small_log)
    assert len(log) == 12
    assert "1 too many beams: 50,001 beams a scan, over the limit of 50,000" in log.report


def test_a_bag_scan_of_too_many_beams_is_skipped_and_named(tmp_path: Path) -> None:
    encoder = Encoder()
    writer = McapWriter(tmp_path / "wide.mcap", encoder, 1 << 20)
    for stamp, beams in enumerate([10, BEAMS.most + 1, 10]):
        scan = LaserScan(float(stamp), -1.0, 1e-5, 0.1, 10.0, np.full(beams, 2.0), 0.0, 0.1)
        writer.write("/scan", 10**9 * stamp, encoder.scan(scan))
    writer.close()
    log = read_log(tmp_path / "wide.mcap")
    assert (len(log), log.lost) == (2, 1)
    assert "1 too many beams: 50,001 beams a scan, over the limit of 50,000" in log.report


@pytest.mark.parametrize("source", ["carmen", "urg text", "mcap"])
def test_a_log_of_too_many_scans_is_read_up_to_the_limit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, source: str
) -> None:
    monkeypatch.setattr(read_statistics, "SCANS", replace(SCANS, most=1))
    reader = READERS[source]
    log = read_log(tmp_path / "seeds" / reader.files(reader.make(tmp_path / "seeds"))[0])
    assert len(log) == 1
    assert "it is read no further: 2 scans a log, over the limit of 1: " in log.report


def test_a_run_of_too_many_scans_is_read_up_to_the_limit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for module in (tum, step_table):
        monkeypatch.setattr(module, "SCANS", replace(SCANS, most=2))
    run_folder(tmp_path)
    shutil.copy(tmp_path / "run" / "trajectory.tum", tmp_path / "run" / "closed.tum")
    record = RunRecord.open(tmp_path / "run")
    assert len(record.traces.stamps) == 2
    assert [damage.split(": ")[1] for damage in record.damage] == ["line 3", "line 3", "line 4", "line 3"]
    assert all("3 scans a log, over the limit of 2: " in damage for damage in record.damage)
    with pytest.raises(InputError, match=r"closed\.tum: line 3: 3 scans a log, over the limit"):
        read_tum(tmp_path / "run" / "closed.tum")


def test_generated_messages_have_the_planned_scans() -> None:
    assert [topic for topic, *_ in messages()].count("/scan") == 4
