"""Readers that are fed damaged files, and small valid files of each kind: see fuzz_containers.py."""

from __future__ import annotations

import bz2
import gzip
import json
import shutil
import struct
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import lz4.frame
import numpy as np
import yaml
from mcap.writer import CompressionType, Writer
from PIL import Image
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Writer2

from slam.config import SlamConfig
from slam.errors import HopslamError
from slam.files.graphs.file import read_graph
from slam.files.logs import read_log
from slam.files.logs.rosbag1 import MAGIC
from slam.files.maps.file import read_map
from slam.files.ros.encoder import Encoder, nanoseconds
from slam.files.ros.messages import TYPES, ros1_types, ros2_types
from slam.files.tum import read_tum
from slam.odometry import Odometry, Twist2D
from slam.pose import Pose2D
from slam.run.experiment_setup import replay_experiment
from slam.run.export.formats import export
from slam.run.report.faults import faults
from slam.run.report.run_section import changes, command
from slam.run.results.metrics import measure, measure_localization
from slam.run.results.run_names import run_names
from slam.run.results.run_record import RunRecord
from slam.run.scoring.pose_errors import read_relations
from slam.scan import LaserScan
from slam.scenario.file import load_scenario, read_scenario
from slam.sweep.folder import Folder
from slam.sweep.lock import SweepLock
from slam.sweep.make_plan import make_plan
from slam.sweep.report.groups import group_runs, pick_metric
from slam.sweep.report.tables import tables
from slam.sweep.result_store import ResultStore

SCANS = 4


@dataclass(frozen=True)
class Reader:
    """A reader, and how the files that it is fed are made in a new folder."""

    make_files: Callable[[Path], Any]
    read: Callable[[Path, str], Any]
    """Reads the folder as all commands do; the second argument is the name of the damaged file."""
    weight: int = 4
    """Relative number of inputs that this one gets."""
    cuts: bool = True
    """True if the files are small, so that they are also truncated at every byte."""
    renews: bool = False
    """True if reading changes the folder, so that it must be made again."""

    def make(self, folder: Path) -> Path:
        """The folder with its files."""
        folder.mkdir(parents=True)
        self.make_files(folder)
        return folder

    @staticmethod
    def copy(seeds: Path, here: Path) -> Path:
        """The folder once more, to be damaged."""
        return Path(shutil.copytree(seeds, here))

    def files(self, seeds: Path) -> list[str]:
        """The names of its files, each of which is damaged in turn."""
        return sorted(str(path.relative_to(seeds)) for path in seeds.rglob("*") if path.is_file())

    def restore(self, seeds: Path, here: Path, file: str) -> None:
        """Make the folder as it was before this file was damaged and read."""
        if self.renews:
            shutil.rmtree(here)
            shutil.copytree(seeds, here)
        else:
            shutil.copyfile(seeds / file, here / file)


def carmen(folder: Path) -> None:
    lines = ["PARAM hopslam_time_increment 0.001 0 h 0", "ODOM 0 0 0 0 0 0 0 h 0"]
    for k in range(SCANS):
        pose, readings = f"{0.05 * k:.3f} 0 0", " ".join(f"{2.0 + 0.1 * ((k + j) % 7):.3f}" for j in range(31))
        lines.append(f"FLASER 31 {readings} {pose} {pose} {0.1 * k:.3f} host {0.1 * k:.3f}")
    text = "\n".join(lines).encode() + b"\n"
    (folder / "a.log").write_bytes(text)
    (folder / "a.log.gz").write_bytes(gzip.compress(text, mtime=0))


def urg_text(folder: Path) -> None:
    rows = ([100_000 * k, 0, 10 * k, 11 * k, *[0] * 20, *(1000 + j % 90 for j in range(682))] for k in range(2))
    (folder / "a.dat").write_text("".join(" ".join(map(str, row)) + "\n" for row in rows))


def messages() -> list[tuple[str, int, bytes]]:
    """Topic, time and CDR of a short drive."""
    encoder, found = Encoder(), []
    for k in range(SCANS):
        stamp, pose = 1.0 + 0.1 * k, Pose2D(0.05 * k)
        ranges = np.linspace(1.0, 3.0, 20)
        scan = LaserScan(stamp, -0.5, 0.0625, 0.125, 4.0, ranges, 0.001)
        time = nanoseconds(stamp)
        if k == 0:
            found.append(("/tf_static", time, encoder.transforms(stamp, ("base_link", "laser", Pose2D(0.1)))))
        found.append(("/tf", time, encoder.transforms(stamp, ("odom", "base_link", pose))))
        found.append(("/odom", time, encoder.odometry(Odometry(stamp, pose, Twist2D(0.5)))))
        found.append(("/scan", time, encoder.scan(scan)))
    return found


def mcap(folder: Path) -> None:
    for packing in CompressionType:
        with (folder / f"{packing.name}.mcap").open("wb") as file:
            writer, encoder, ids = Writer(file, chunk_size=900, compression=packing), Encoder(), dict[str, int]()
            writer.start("ros2", "hopslam")
            for topic, time, data in messages():
                if topic not in ids:
                    schema = writer.register_schema(TYPES[topic], "ros2msg", encoder.definition(TYPES[topic]).encode())
                    ids[topic] = writer.register_channel(topic, "cdr", schema)
                writer.add_message(ids[topic], time, data, time)
            writer.finish()


def ros2_bag(folder: Path, storage: StoragePlugin, mode: CompressionMode = CompressionMode.NONE) -> None:
    bag = Writer2(folder / "bag", version=9, storage_plugin=storage)
    if mode is not CompressionMode.NONE:
        bag.set_compression(mode, CompressionFormat.ZSTD)
    with bag:
        kinds = {topic: TYPES[topic] for topic, *_ in messages()}
        ids = {topic: bag.add_connection(topic, kind, typestore=ros2_types()) for topic, kind in kinds.items()}
        for topic, time, data in messages():
            bag.write(ids[topic], time, data)


def record(data: bytes, **fields: bytes) -> bytes:
    """A record of a ROS 1 bag."""
    parts = [name.encode() + b"=" + value for name, value in fields.items()]
    header = b"".join(struct.pack("<I", len(part)) + part for part in parts)
    return struct.pack("<I", len(header)) + header + struct.pack("<I", len(data)) + data


def ros1_bag(folder: Path) -> None:
    kind, number = b"type=sensor_msgs/LaserScan", bytes(4)
    body = record(struct.pack("<I", len(kind)) + kind, op=b"\x07", conn=number, topic=b"/scan")
    for topic, time, data in messages():
        if topic == "/scan":
            raw = bytes(ros1_types().serialize_ros1(_as_ros1(data), TYPES[topic]))
            body += record(raw, op=b"\x02", conn=number, time=struct.pack("<II", *divmod(time, 10**9)))
    for name, pack in {"none": bytes, "bz2": bz2.compress, "lz4": lz4.frame.compress}.items():
        chunk = record(pack(body), op=b"\x05", compression=name.encode(), size=struct.pack("<I", len(body)))
        (folder / f"{name}.bag").write_bytes(MAGIC + record(b" " * 100, op=b"\x03") + chunk + chunk)


def _as_ros1(data: bytes) -> Any:
    scan, types = ros2_types().deserialize_cdr(data, TYPES["/scan"]), ros1_types().types
    stamp = types["builtin_interfaces/msg/Time"](scan.header.stamp.sec, scan.header.stamp.nanosec)
    header = types["std_msgs/msg/Header"](0, stamp, scan.header.frame_id)
    values = {name: getattr(scan, name) for name in scan.__dataclass_fields__ if name not in ("header", "__msgtype__")}
    return types[TYPES["/scan"]](header=header, **values)


def poses(folder: Path) -> None:
    (folder / "a.tum").write_text("".join(f"{k} {k} 0 0 0 0 0 1\n" for k in range(6)))


def relations(folder: Path) -> None:
    (folder / "a.relations").write_text("".join(f"{k} {k + 1} 1 0 0 0 0 0\n" for k in range(6)))


def scenario(folder: Path) -> None:
    text = {"extends": "corridor", "duration": 5, "slam": {"map": {"cell": 0.2}}, "robot": {"start": {"y": 0.1}}}
    (folder / "a.yaml").write_text(yaml.safe_dump(text) + "description: &x a\nname: *x\n")


def ros_map(folder: Path) -> None:
    pixels = np.full((20, 30), 254, np.uint8)
    pixels[5:8, 4:20] = 0
    for name in ("map.pgm", "map.png", "map.bmp"):
        Image.fromarray(pixels).save(folder / name)
        header = {"image": name, "resolution": 0.05, "origin": [0.0, 0.0, 0.0], "negate": 0, "occupied_thresh": 0.65}
        (folder / f"{name}.yaml").write_text(yaml.safe_dump(header))


def run_folder(folder: Path) -> None:
    carmen(folder)
    scenario = load_scenario("replay")
    made = replay_experiment(folder / "a.log", scenario).run(folder / "run", pictures=False).folder
    shutil.copy(made / "trajectory.tum", made / "groundtruth.tum")
    for name in ("a.log", "a.log.gz"):
        (folder / name).unlink()


def map_and_graph(folder: Path) -> None:
    run_folder(folder)
    for name in ("map.json", "graph.json"):
        shutil.move(folder / "run" / name, folder / name)
    shutil.rmtree(folder / "run")


def sweep_folder(folder: Path) -> None:
    folder.mkdir(exist_ok=True)
    store = ResultStore(Folder(str(folder)))
    for seed in range(4):
        store.add(sweep_row(seed))
        if seed == 2:
            store.compact()
    (folder / "sweep.yaml").write_text("name: a\nscenarios: [corridor]\nseeds: 0:4\n")
    (folder / "driver.lock").write_text('{"host": "there", "pid": 1}')


def sweep_row(seed: int) -> dict[str, Any]:
    """A row of a run that came to its end."""
    texts = {"name": "corridor", "source": "corridor", "kind": "scenario", "mode": "hopslam", "command": "hopslam run"}
    numbers = {"ate_rmse_m": 0.1 + 0.01 * seed, "path_m": 3.0, "set.slam.map.cell": 0.2, "seconds": 1.0}
    rest = {"status": "done", "ending": "arrived", "error": None, "settings": ["a=1"], "error_m": [0.0, 0.1]}
    return {"id": f"{seed:016x}", "seed": seed, **texts, **numbers, **rest}


def read_scans(folder: Path, file: str) -> None:
    """Read the log in this file, or in its folder."""
    log = read_log(folder / Path(file).parts[0])
    for k in range(len(log)):
        log.scan(k).points()
        log.odometry(k)


def try_all(ways: list[Callable[[], Any]]) -> None:
    """Call all these readers, even if one fails; then raise the last error."""
    refused: HopslamError | None = None
    for way in ways:
        try:
            way()
        except HopslamError as error:
            refused = error
    if refused is not None:
        raise refused


def read_run(folder: Path, file: str) -> None:
    """Read everything that report, export, optimize, eval and view read; draw nothing."""
    record = RunRecord.open(folder / "run")
    out = folder / ".out"
    ways: list[Callable[[], Any]] = [
        lambda: measure(record.folder), lambda: measure_localization(record.folder), lambda: record.walls,
        lambda: record.segments, lambda: record.graph, lambda: record.saved_map, lambda: list(record.observations()),
        lambda: (record.start, record.T_base_laser), lambda: read_scans(folder, "run"),
        lambda: faults(record, record.metrics or measure(record.folder)), lambda: run_names([record, record]),
        lambda: changes(record.config), lambda: command(record, record.metrics or {}),
        *(partial(export, record, to, out, True) for to in ("tum", "csv", "g2o", "carmen", "mcap", "geojson")),
    ]  # fmt: skip
    try_all(ways)


def read_sweep(folder: Path, file: str) -> None:
    """Read everything that sweep, its plan and its report read; draw nothing."""
    store = ResultStore(Folder(str(folder)))
    with SweepLock(Folder(str(folder))):
        store.set_damaged_aside()
        store.compact()
    store.done()
    metric = pick_metric(store, None)
    tables(group_runs(store, metric), metric)


def read_plan(folder: Path, file: str) -> None:
    make_plan(str(folder / file), {})


def sweep_file(folder: Path) -> None:
    text = {"scenarios": ["corridor"], "seeds": "0:10", "grid": {"slam.map.cell": [0.1, 0.2]}, "modes": ["hopslam"]}
    (folder / "a.yaml").write_text(yaml.safe_dump(text))


def read_ros_map(folder: Path, file: str) -> None:
    header = folder / (file if file.endswith(".yaml") else f"{file}.yaml")
    read_scenario("corridor", [f"world.map={json.dumps({'file': str(header)})}"])


def read_map_or_graph(folder: Path, file: str) -> None:
    read_graph(folder / file) if file == "graph.json" else read_map(folder / file, SlamConfig())


MESSAGE, FILE = CompressionMode.MESSAGE, CompressionMode.FILE
SQLITE, MCAP = StoragePlugin.SQLITE3, StoragePlugin.MCAP
READERS = {
    "carmen": Reader(carmen, read_scans),
    "urg text": Reader(urg_text, read_scans),
    "ros1 bag": Reader(ros1_bag, read_scans),
    "mcap": Reader(mcap, read_scans),
    "ros2 sqlite3": Reader(partial(ros2_bag, storage=SQLITE), read_scans),
    "ros2 mcap": Reader(partial(ros2_bag, storage=MCAP), read_scans),
    "ros2 messages": Reader(partial(ros2_bag, storage=SQLITE, mode=MESSAGE), read_scans, weight=2),
    "ros2 file": Reader(partial(ros2_bag, storage=SQLITE, mode=FILE), read_scans, weight=2),
    "tum": Reader(poses, lambda folder, file: read_tum(folder / file)),
    "relations": Reader(relations, lambda folder, file: read_relations(folder / file)),
    "scenario": Reader(scenario, lambda folder, file: read_scenario(folder / file), weight=2),
    "ros map": Reader(ros_map, read_ros_map, weight=2),
    "run folder": Reader(run_folder, read_run, weight=4, cuts=False),
    "map and graph": Reader(map_and_graph, read_map_or_graph),
    "sweep file": Reader(sweep_file, read_plan, weight=2),
    "sweep folder": Reader(sweep_folder, read_sweep, weight=2, renews=True),
}
