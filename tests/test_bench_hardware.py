"""The benchmarks of the drivers: what they compute and print."""

from functools import partial

import numpy as np
import pytest
from typer.testing import CliRunner

from hardware.bench.driven_path import PathDifference
from hardware.bench.sim_comparison import drive_env_emulated, drive_env_simulated
from slam.cli.main import app
from slam.scenario.file import load_scenario


def out_and_back(offset: float, late: int) -> np.ndarray:
    """Ten metres and back, 5 cm a scan, after standing for a while."""
    x = np.arange(0.0, 10.0, 0.05)
    out = np.column_stack([x, np.full(len(x), offset), np.zeros(len(x))])
    turn = np.column_stack([np.full(30, x[-1]), np.full(30, offset), np.linspace(0.0, np.pi, 30)])
    return np.concatenate([np.repeat(out[:1], late, axis=0), out, turn, np.add(out[::-1], [0.0, 0.0, np.pi])])


def test_paths_are_compared_by_place_not_by_time() -> None:
    apart = PathDifference.between(out_and_back(0.0, 3), out_and_back(0.04, 17))
    assert apart.largest == pytest.approx(0.04, abs=1e-6)
    assert apart.rms == pytest.approx(0.04, abs=1e-6)
    assert apart.heading == pytest.approx(0.0, abs=1e-9)
    assert apart.ends == pytest.approx(0.04, abs=1e-2)
    assert apart.length == pytest.approx(20.0, abs=0.3)


def test_a_robot_that_waits_stays_on_its_leg() -> None:
    path = out_and_back(0.02, 3)
    waited = np.concatenate([path[:60], np.repeat(path[60:61], 40, axis=0), path[60:]])
    apart = PathDifference.between(out_and_back(0.0, 3), waited)
    assert apart.largest == pytest.approx(0.02, abs=1e-6)
    assert apart.length == pytest.approx(20.0, abs=0.3)


def test_a_policy_drives_devices_as_it_does_the_simulation() -> None:
    goal = (0.5, 0.0)
    load = partial(load_scenario, "corridor")
    simulated, emulated = drive_env_simulated(load, [], goal), drive_env_emulated(load, [], goal, "plan")
    for path in (simulated, emulated):
        assert np.hypot(*(path.truth[-1, :2] - goal)) < 0.3  # a busy machine may stop late
        assert np.abs(path.truth[:, 1]).max() < 0.05
    assert emulated.errors.max() < 0.05
    assert simulated.errors.max() == 0.0


def test_the_noise_table_has_its_rows() -> None:
    result = CliRunner().invoke(app, ["bench", "hardware", "noise", "--packets", "5"])
    assert result.exit_code == 0
    assert "A noisy wire" in result.output
