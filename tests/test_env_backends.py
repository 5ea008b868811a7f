"""One environment over every back end: the same spaces, keys and rules for each robot."""

import gc
import importlib
import logging
import runpy
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import sim  # noqa: F401  registers the ids
from hardware.emulator.emulator import Emulator
from hardware.emulator.pty_port import PtyPort
from sim.plant import plan_plant
from slam.errors import InputError, RobotError, RobotTimeout
from slam.lidars import URG04LX
from slam.odometry import Odometry, Twist2D
from slam.pose import Pose2D
from slam.robot import Observation
from slam.scan import LaserScan
from slam.scenario.file import load_scenario
from slam.scenario.schema import Scenario
from tests.rooms import room_plant

ID = "hopslam/Corridor-v0"
EXAMPLES = Path(__file__).parents[1] / "docs/examples"
ALL_VIEWS = ("scan", "odometry", "slam_pose", "map", "goal")
FORWARD = np.array([0.4, 0.0], np.float32)
PATIENCE = 20.0
"""Seconds after which a test fails if its condition is still false: many, for a busy machine."""


@pytest.fixture(autouse=True)
def quiet(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.WARNING)


@contextmanager
def devices(*ports: PtyPort, scenario: str = "corridor") -> Iterator[tuple[Emulator, list[str]]]:
    """Emulated devices without physics, and the settings that name their ports."""
    with Emulator(plan_plant(load_scenario(scenario)), *ports, paced=False) as emulator:  # type: ignore[misc]
        yield emulator, emulator.port_settings


@contextmanager
def on_devices(*settings: str, **arguments: Any) -> Iterator[tuple[gymnasium.Env, Emulator]]:
    with devices() as (emulator, ports):
        given = {"backend": "hardware", "yes": True, "settings": [*ports, *settings]} | arguments
        with gymnasium.make(ID, **given) as env:
            yield env, emulator


@contextmanager
def simulated(*settings: str, **arguments: Any) -> Iterator[tuple[gymnasium.Env, None]]:
    with gymnasium.make(ID, settings=settings, **arguments) as env:
        yield env, None


def still(emulator: Emulator) -> bool:
    return not emulator.p3dx.motors.moving


def wait_until(condition: Callable[[], object]) -> None:
    until = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < until, "it never came true"
        time.sleep(0.01)


def drive(env: gymnasium.Env, steps: int) -> None:
    for _ in range(steps):
        env.step(FORWARD)


def pose(values: np.ndarray) -> Pose2D:
    return Pose2D(*values.tolist())


def test_with_devices_the_rules_of_gymnasium_are_kept() -> None:
    with on_devices(observe=ALL_VIEWS) as (env, _):
        env.unwrapped.spec.nondeterministic = True  # in real time no two runs are equal
        check_env(env.unwrapped, skip_render_check=True)  # which would open the ports a second time


@pytest.mark.parametrize("arguments", [{}, {"observe": ALL_VIEWS, "end_on": "lost", "reward": "coverage"}])
def test_device_spaces_equal_simulated_ones_without_truth(arguments: dict[str, object]) -> None:
    kinds = []
    for opened in (simulated, on_devices):
        with opened(**arguments) as (env, _):
            first, info = env.reset(seed=1)
            observation, reward, *_, later = env.step(FORWARD)
            assert first in env.observation_space
            assert observation in env.observation_space
            assert isinstance(reward, float)
            assert later["applied"] == pytest.approx(FORWARD)
            assert info["pose_from"] == ("truth" if opened is simulated else "estimate")
            assert np.isnan(info["T_map_base"]).all() == (opened is on_devices)
            if opened is simulated:
                np.testing.assert_array_equal(info["pose"], info["T_map_base"])
            elif "slam_pose" in info:
                np.testing.assert_array_equal(info["pose"], info["slam_pose"])
                assert np.isnan(info["slam_error"])
            shapes = [(key, type(info[key]), np.shape(info[key])) for key in sorted(info) if key != "observation"]
            kinds.append((env.observation_space, env.action_space, shapes, sorted(later)))
    assert kinds[0] == kinds[1]


def test_device_episodes_begin_where_the_robot_stands() -> None:
    with on_devices("route.waypoints=[[1.0, 0.0]]", max_seconds=1.0, render_mode="rgb_array") as (env, emulator):
        _, info = env.reset(seed=1)
        left, rewards, truncated = info["route_left"], [], False
        while not truncated:
            _, reward, _, truncated, info = env.step(FORWARD)
            rewards.append(reward)
        assert info["ending"] == "time"
        assert sum(rewards) == pytest.approx(left - info["route_left"])
        assert env.render().shape[2] == 3
        wait_until(lambda: still(emulator))
        _, info = env.reset()
        assert pose(info["pose"]).distance(emulator.truth[1]) < 0.02
        assert info["seconds"] == pytest.approx(0.1)
        assert 0.05 < info["pose"][0]
        env.reset(options={"goal": [info["pose"][0] + 0.2, 0.0]})
        over = False
        while not over:
            *_, terminated, truncated, info = env.step(FORWARD)
            over = terminated or truncated
        assert info["ending"] == "goal"
        env.close()  # and the robot is carried back
        assert still(emulator)
        assert not emulator.p3dx.open
        _, info = env.reset()
        assert pose(info["pose"]).distance(Pose2D()) < 1e-9


def test_a_real_robot_cannot_be_placed() -> None:
    with on_devices() as (env, emulator):
        with pytest.raises(InputError, match=r"start: this robot cannot be put anywhere.*carry the robot"):
            env.reset(options={"start": [1.0, 0.0]})
        assert not emulator.p3dx.open


def test_a_failed_device_stops_the_robot_and_is_reported(tmp_path: Path) -> None:
    with devices(PtyPort(tmp_path / "p3dx"), PtyPort(tmp_path / "urg04lx")) as (emulator, ports):
        settings = [*ports, "hardware.patience=0"]
        with gymnasium.make(ID, backend="hardware", yes=True, settings=settings) as env:
            env.reset(seed=0)
            env.step(FORWARD)
            emulator.do(emulator.lidar.unplug)
            with pytest.raises(RobotTimeout, match="no such port"):
                drive(env, 10)
            assert not emulator.p3dx.open
            assert still(emulator)
            with pytest.raises(RobotError, match="call reset"):
                env.step(FORWARD)
            emulator.do(emulator.lidar.port.open)
            _, info = env.reset()
            assert pose(info["pose"]).distance(emulator.truth[1]) < 0.3  # it rolled on while nothing was seen


def test_a_disconnected_lidar_is_waited_for() -> None:
    with on_devices() as (env, emulator):
        env.reset(seed=0)
        emulator.do(lambda: emulator.lidar.stall(emulator.now + 1.3))
        stalled = emulator.now
        while emulator.now < stalled + 1.3:
            *_, info = env.step(FORWARD)
        assert info["applied"] == pytest.approx([0.0, 0.0])
        *_, info = env.step(FORWARD)
        assert info["applied"] == pytest.approx(FORWARD)


@pytest.mark.parametrize("thread", ["main", "another"])
def test_an_unreferenced_robot_stops(thread: str) -> None:
    with devices() as (emulator, ports):
        env = gymnasium.make(ID, backend="hardware", yes=True, settings=ports)
        env.reset(seed=0)
        while still(emulator):
            env.step(FORWARD)
        if thread == "main":
            del env
            gc.collect()
            assert not emulator.p3dx.open
        else:
            held, ring = [env], list[Any]()
            ring.append((ring, held.pop()))
            del env, ring
            with ThreadPoolExecutor() as pool:
                pool.submit(gc.collect).result()
        wait_until(lambda: still(emulator) and not emulator.p3dx.open)


def test_interruptions_and_wrong_actions_stop_the_robot(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(timeout: float = 1.0) -> None:
        raise KeyboardInterrupt

    with on_devices() as (env, emulator):
        env.reset(seed=0)
        while still(emulator):
            env.step(FORWARD)
        with pytest.raises(InputError, match="did learning diverge"):
            env.unwrapped.step([np.nan, 0.0])
        wait_until(lambda: still(emulator))
        while still(emulator):
            env.step(FORWARD)
        monkeypatch.setattr(env.unwrapped.robot, "observe", interrupted)
        with pytest.raises(KeyboardInterrupt):
            env.step(FORWARD)
        assert still(emulator)
        assert not emulator.p3dx.open


def test_without_consent_or_in_a_dry_run_nothing_moves() -> None:
    with on_devices(dry_run=True, yes=False) as (env, emulator):
        env.reset(seed=0)
        *_, info = env.step(FORWARD)
        np.testing.assert_array_equal(info["applied"], [0.0, 0.0])
        assert not emulator.p3dx.motors.enabled
    with on_devices(yes=False) as (env, emulator):
        env.reset(seed=0)
        with pytest.raises(RobotError, match="nobody can be asked"):
            env.step(FORWARD)
        assert not emulator.p3dx.open


@pytest.mark.parametrize("policy", ["by-hand", "ppo"])
def test_the_documented_command_lets_a_policy_drive(
    policy: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.syspath_prepend(str(EXAMPLES))
    if policy == "ppo":
        policy = saved_ppo(tmp_path)
    with devices(scenario="random_office") as (emulator, ports):
        words = [word for setting in [*ports, "duration=3"] for word in ("--set", setting)]
        monkeypatch.setattr("sys.argv", ["drive.py", policy, "--backend", "hardware", "--yes", *words])
        with pytest.raises(SystemExit) as ended:
            runpy.run_path(str(EXAMPLES / "drive.py"), run_name="__main__")
        assert not ended.value.code
        assert emulator.truth[1].distance(load_scenario("random_office").robot.start.pose) > 0.05
    assert "time after 3.0 s" in (out := capsys.readouterr().out)
    assert "where SLAM believes the robot is" in out


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["drive.py", "nowhere.zip"], "no policy nowhere.zip; train.py writes one, and by-hand needs none"),
        (["drive.py", "policy.zip"], "a trained policy needs stable-baselines3: pip install 'hopslam[rl]'"),
        (["drive.py", "policy"], "a trained policy needs stable-baselines3: pip install 'hopslam[rl]'"),
        (["drive.py", "broken.zip"], "broken.zip is not a policy that PPO loads: not a zip file"),
        (["drive.py", "by-hand", "--set", "duration=x"], "--set: duration: expected a number (got 'x')"),
        (["train.py"], "train.py needs stable-baselines3: pip install 'hopslam[rl]'"),
    ],
)
def test_a_missing_package_of_the_examples_is_one_line(
    words: list[str], says: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(EXAMPLES))
    for name in ("policy.zip", "broken.zip"):
        Path(name).touch()
    broken = SimpleNamespace(PPO=SimpleNamespace(load=lambda *_, **__: refuse("not a zip file\nat all")))
    monkeypatch.setitem(sys.modules, "stable_baselines3", broken if "broken.zip" in words else None)
    monkeypatch.setattr("sys.argv", words)
    with pytest.raises(SystemExit) as ended:
        runpy.run_path(str(EXAMPLES / words[0]), run_name="__main__")
    assert (ended.value.code, capsys.readouterr().err) == (2, f"{says}\n")


def refuse(why: str) -> None:
    raise ValueError(why)


def saved_ppo(folder: Path) -> str:
    """A policy that has learnt nothing, but to go straight ahead."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of its own imports
        ppo = pytest.importorskip("stable_baselines3", reason="pip install 'hopslam[rl]'").PPO
    explorer = importlib.import_module("explorer").explorer
    model = ppo("MlpPolicy", explorer(), device="cpu")
    model.policy.action_net.bias.data[0] = 0.5
    model.save(folder / "policy")
    return str(folder / "policy.zip")


class Room:
    """A user's own robot: it stands in a square room, does not know its true pose, and stalls at the third scan."""

    def __init__(self, scenario: Scenario, seed: int | None = None) -> None:
        self.T_base_laser, self.turns, self.left = Pose2D(), 0, 0
        self._plant = room_plant((-3.0, 3.0), (-3.0, 3.0))

    def __enter__(self) -> "Room":
        return self

    def __exit__(self, *_: object) -> None:
        self.left += 1

    def observe(self, timeout: float = 1.0) -> Observation | None:
        self.turns += 1
        lidar = URG04LX.lidar
        ranges = self._plant.ranges(lidar.angles)
        bounds = lidar.angle_min, lidar.angle_increment, lidar.range_min, lidar.range_max
        scan = LaserScan(0.1 * self.turns, *bounds, np.where(ranges > lidar.range_max, np.inf, ranges))
        stalled = self.turns == 3
        return Observation(scan, Odometry(scan.stamp, Pose2D()), stalled=stalled) if self.turns < 5 else None

    def drive(self, command: Twist2D) -> Twist2D:
        return command


class RestartableRoom(Room):
    """The same, simulated."""

    def restart(self, seed: int) -> None:
        self.turns = 0


@pytest.fixture
def rooms(monkeypatch: pytest.MonkeyPatch) -> Iterator[ExitStack]:
    monkeypatch.setitem(__import__("sys").modules, "rooms_of_a_user", __import__("types").SimpleNamespace(**globals()))
    with ExitStack() as stack:
        yield stack


def test_blocked_wheels_are_a_collision(rooms: ExitStack) -> None:
    env = rooms.enter_context(gymnasium.make(ID, backend="rooms_of_a_user:Room", collision_penalty=2.0))
    env.reset(seed=0)
    ends = [env.step(FORWARD)[2] for _ in range(2)]
    assert ends == [False, True]
    with pytest.raises(InputError, match=r"the episode is over: call reset\(\)"):
        env.step(FORWARD)
    env = rooms.enter_context(gymnasium.make(ID, backend="rooms_of_a_user:Room", collision_penalty=2.0, end_on="goal"))
    env.reset(seed=0)
    assert [env.step(FORWARD)[4]["reward"]["collision"] for _ in range(3)] == [0.0, -2.0, 0.0]


def test_a_robot_without_more_scans_truncates(rooms: ExitStack) -> None:
    env = rooms.enter_context(gymnasium.make(ID, backend="rooms_of_a_user:Room", end_on="goal"))
    env.reset(seed=0)
    ends = [env.step(FORWARD)[3] for _ in range(4)]
    assert ends == [False, False, False, True]


@pytest.mark.parametrize(("name", "is_new"), [("Room", True), ("RestartableRoom", False)])
def test_only_a_resettable_robot_is_reused(rooms: ExitStack, name: str, is_new: bool) -> None:
    env = rooms.enter_context(gymnasium.make(ID, backend=f"rooms_of_a_user:{name}", end_on="goal"))
    env.reset(seed=0)
    first = env.unwrapped.robot
    room = first._robot
    env.step(FORWARD)
    env.reset(seed=1)
    assert (env.unwrapped.robot is not first) == is_new
    assert room.left == is_new
    env.close()


def test_scans_of_another_lidar_are_refused(rooms: ExitStack) -> None:
    arguments = {"backend": "rooms_of_a_user:Room", "settings": "lidar.model=table1"}
    env = rooms.enter_context(gymnasium.make(ID, **arguments))
    with pytest.raises(RobotError, match=r"682 beams and reach \S+ m; those of lidar\.model table1 have 128"):
        env.reset(seed=0)


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        ({"backend": "replay"}, "a recorded log obeys no agent"),
        ({"backend": "hardwear"}, "did you mean hardware?"),
        ({"yes": True}, "add backend='hardware'"),
        ({"dry_run": True}, "add backend='hardware'"),
    ],
)
def test_an_undrivable_robot_is_refused_at_construction(arguments: dict[str, object], complaint: str) -> None:
    with pytest.raises(InputError, match=complaint):
        gymnasium.make(ID, **arguments)
