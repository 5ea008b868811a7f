"""Memory and file descriptors do not grow: resets of an environment, drivers fed garbage, an hour of a run."""

import gc
import random
import tracemalloc
from collections.abc import Callable, Iterator
from pathlib import Path
from resource import getpagesize
from time import sleep

import gymnasium
import pytest

import sim  # noqa: F401  registers the ids
from hardware.arcos.packet import HEADER, PacketDecoder
from hardware.scip.frames import FrameDecoder
from hardware.scip.reply import find_reply
from tests.killed_commands import is_running, result_of, start

PIECE = 4096
LAP = "[7, 0], [7, 8], [-7, 8], [-7, 0], [0, 0]"
HOUR = ["--set", "lidar.caster=exact", "--set", "duration=3600", "--set", f"route.waypoints=[{', '.join([LAP] * 40)}]"]
MIB = 1 << 20


def resident(process: int | str = "self") -> int:
    """Bytes of memory of a process."""
    return int(Path(f"/proc/{process}/statm").read_text().split()[1]) * getpagesize()


def descriptors(process: int | str = "self") -> int:
    """Number of the files that a process has open."""
    return sum(1 for _ in Path(f"/proc/{process}/fd").iterdir())


@pytest.mark.parametrize("scenario", ["paper_simulation", "crowded_corridor"])
def test_resets_of_an_environment_leak_no_memory(scenario: str, pytestconfig: pytest.Config) -> None:
    resets = 2000 if pytestconfig.getoption("--all-faults") else 20
    with gymnasium.make("hopslam/P3DX-v0", scenario=scenario) as env:
        for seed in range(10):
            env.reset(seed=seed)
        gc.collect()
        memory, files = resident(), descriptors()
        for seed in range(resets):
            env.reset(seed=seed)
            env.step(env.action_space.sample())
        gc.collect()
        assert descriptors() == files
        growth = resident() - memory
    print(f"\n{scenario}: {resets} resets, {growth / resets:.0f} bytes more a reset")
    assert growth < 8 * MIB


def garbage(count: int, seed: int) -> Iterator[bytes]:
    """Yield ``count`` bytes in pieces: random bytes, and repeated beginnings and ends of messages."""
    rng = random.Random(seed)
    for _ in range(count // PIECE):
        burst = rng.choice([HEADER, b"\xfa", b"\n", b"\n\n", b"MD0044072501000\n", b"0\n00\n", HEADER + b"\xc5"])
        yield rng.randbytes(PIECE) if rng.random() < 0.8 else burst * (PIECE // len(burst))


def arcos() -> Callable[[bytes], object]:
    return PacketDecoder().feed


def scip() -> Callable[[bytes], object]:
    decoder = FrameDecoder()

    def feed(data: bytes) -> None:
        for lines in decoder.feed(data):
            find_reply(lines)

    return feed


@pytest.mark.parametrize("driver", [arcos, scip])
def test_a_driver_fed_garbage_leaks_no_memory(
    driver: Callable[[], Callable[[bytes], object]], pytestconfig: pytest.Config
) -> None:
    count = 10**7 if pytestconfig.getoption("--all-faults") else 10**5
    feed = driver()
    tracemalloc.start()
    try:
        for piece in garbage(count, seed=1):
            feed(piece)
        assert tracemalloc.get_traced_memory()[0] < 64 * 1024
        assert tracemalloc.get_traced_memory()[1] < 4 * MIB
    finally:
        tracemalloc.stop()


def test_an_hour_of_a_simulated_run_leaks_no_memory(tmp_path: Path, pytestconfig: pytest.Config) -> None:
    if not pytestconfig.getoption("--all-faults"):
        pytest.skip("takes minutes; make test-all runs it")
    out = tmp_path / "run"
    run = start(["run", "office_loop", *HOUR, "--out", str(out)])
    seen = list[tuple[int, int, int]]()
    while is_running(run.child):
        if (out / "odometry.tum").is_file():
            scans = (out / "odometry.tum").read_bytes().count(b"\n")
            seen.append((scans, resident(run.child), descriptors(run.child)))
        sleep(2.0)
    assert result_of(run) == 0
    driven = [row for row in seen if 9000 < row[0] < 35_900]
    (first, before, files), (last, after, files_after) = driven[0], driven[-1]
    print(
        f"\n{last} scans, {before / MIB:.0f} to {after / MIB:.0f} MiB: {(after - before) / (last - first):.0f} a scan"
    )
    assert last > 35_000
    assert files_after == files
    assert (after - before) / (last - first) < 1024
