"""No file makes code run, or a module be imported, unless the user allows it."""

import importlib
import json
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import gymnasium
import pytest
import yaml
from typer.testing import CliRunner

from slam.cli.main import app
from slam.config import OwnMethod, SlamConfig
from slam.errors import HopslamError, InputError, ScenarioError
from slam.line_slam import LineSlam
from slam.pose import Pose2D
from slam.run.experiment_setup import scenario_experiment
from slam.scenario.file import load_scenario, read_scenario
from slam.scenario.schema import Scenario
from slam.sweep.make_plan import make_plan

GADGET = """
from pathlib import Path
from subprocess import run
from slam.config import ChiSquareConfig
from slam.lines.chi_square import segments_by_chi_square

def mark(line):
    with Path(__file__).with_name("ran").open("a") as file:
        file.write(line + "\\n")

mark("imported")

def find(scan, **options):
    mark(f"called {sorted(options)}")
    return segments_by_chi_square(scan, ChiSquareConfig())
"""
OWN = {"method": "gadget:find", "options": {"cmd": "touch pwned"}}
SCENARIOS = {
    "lines": {"extends": "corridor", "duration": 0.5, "slam": {"lines": OWN}},
    "matching": {"extends": "corridor", "duration": 0.5, "slam": {"matching": OWN}},
    "method drawn": {"extends": "corridor", "slam": {"lines": OWN | {"method": {"choice": ["gadget:find"] * 2}}}},
    "section drawn": {"extends": "corridor", "slam": {"lines": {"choice": [{"method": "paper"}, OWN]}}},
    "slam drawn": {"extends": "corridor", "slam": {"choice": [{"mode": "paper"}, {"lines": OWN}]}},
    "extended": {"extends": "below.yaml", "duration": 0.5},
    "paper": {"extends": "corridor", "slam": {"mode": "paper", "lines": OWN}},
    "dead reckoning": {"extends": "corridor", "slam": {"mode": "dead_reckoning", "lines": OWN}},
}
SWEEPS = {
    "settings": {"settings": {"slam.lines.method": "gadget:find"}},
    "section": {"settings": {"slam.lines": OWN}},
    "grid": {"grid": {"slam.lines.method": ["paper", "gadget:find"]}},
    "sections of the grid": {"grid": {"slam.matching": [{}, OWN]}},
    "sample": {"sample": {"slam.lines.method": {"choice": ["chi_square", "gadget:find"]}}},
    "setting drawn": {"settings": {"slam.lines.method": {"choice": ["chi_square", "gadget:find"]}}},
    "scenario": {"scenarios": ["evil.yaml"]},
}


@pytest.fixture(autouse=True)
def gadget(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Yield the file that the module ``gadget`` writes to when it is imported and called, in workers too."""
    folder = tmp_path / "modules"
    folder.mkdir()
    (folder / "gadget.py").write_text(GADGET)
    monkeypatch.syspath_prepend(folder)
    monkeypatch.setenv("PYTHONPATH", str(folder))
    monkeypatch.chdir(tmp_path)
    yield folder / "ran"
    sys.modules.pop("gadget", None)


@pytest.fixture(scope="module")
def plain_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short run in a bare room."""
    folder = tmp_path_factory.mktemp("plain")
    experiment = scenario_experiment(load_scenario("umbmark_room", ["duration=1.0"]))
    return experiment.run(folder / "run", pictures=False).folder


@pytest.fixture
def run_folder(tmp_path: Path, plain_run: Path) -> Path:
    """A run whose config.yaml names the gadget."""
    folder = shutil.copytree(plain_run, tmp_path / "run")
    config = yaml.safe_load((folder / "config.yaml").read_text())
    config["slam"]["lines"] = OWN
    write(folder / "config.yaml", config)
    return folder


def hopslam(*words: object) -> tuple[int, str]:
    """Run a command; return its exit code and its output, which for an error is the message that ``main`` prints."""
    done = CliRunner().invoke(app, list(map(str, words)))
    if isinstance(done.exception, HopslamError):
        return done.exception.exit_code, str(done.exception)
    return done.exit_code, done.output


def write(path: Path, data: dict[str, Any]) -> Path:
    path.write_text(yaml.safe_dump(data, sort_keys=False))
    return path


def is_refused(done: tuple[int, str], *places: str) -> bool:
    """One line, with the place, and with how to allow it."""
    code, line = done
    is_complete = all(place in line for place in (*places, "gadget:find", "--allow-module gadget"))
    return code == 2 and "\n" not in line.strip() and is_complete


@pytest.mark.parametrize("kind", SCENARIOS)
def test_a_scenario_that_names_code_is_refused(kind: str, tmp_path: Path, gadget: Path) -> None:
    write(tmp_path / "below.yaml", SCENARIOS["lines"])
    file = write(tmp_path / "evil.yaml", SCENARIOS[kind])
    place = "below.yaml:" if kind == "extended" else "evil.yaml:"
    assert is_refused(hopslam("run", file), place, "slam.")
    with pytest.raises(ScenarioError, match=f"{place}.*allow_modules="):
        gymnasium.make("sim:hopslam/P3DX-v0", scenario=file)
    assert read_scenario(file).name == "evil"
    assert not gadget.exists()


def test_no_command_runs_what_a_scenario_names(tmp_path: Path, gadget: Path, small_log: Path) -> None:
    file = write(tmp_path / "evil.yaml", SCENARIOS["lines"])
    for words in (
        ("run", file, "--set", "duration=1", "--allow-module", "other"),
        ("replay", small_log, "--scenario", file),
        ("localize", file, "--map", "map.json"),
        ("localize", small_log, "--map", "map.json", "--scenario", file),
        ("sweep", file, "--plan"),
        ("sweep", file, "--jobs", "1"),
        ("calibrate", "square", file),
        ("bench", "localize", file),
        ("bench", "viewer", file),
    ):
        assert is_refused(hopslam(*words), "evil.yaml:5: slam.lines.method"), words
    assert hopslam("world", file)[0] == 0
    assert not gadget.exists()
    assert not Path("pwned").exists()


@pytest.mark.parametrize("kind", SWEEPS)
def test_no_command_runs_what_a_sweep_names(kind: str, tmp_path: Path, gadget: Path) -> None:
    write(tmp_path / "evil.yaml", SCENARIOS["lines"])
    sweep = write(tmp_path / "sweep.yaml", {"scenarios": ["corridor"], "seeds": 0} | SWEEPS[kind])
    place = "evil.yaml:5: slam.lines.method" if kind == "scenario" else "sweep.yaml:"
    for words in (("sweep", sweep, "--plan"), ("sweep", sweep), ("sweep", sweep, "--ray", "127.0.0.1:9")):
        assert is_refused(hopslam(*words), place), words
    assert not gadget.exists()


def test_no_command_runs_what_a_run_folder_names(run_folder: Path, gadget: Path) -> None:
    for words in (
        ("replay", run_folder),
        ("optimize", run_folder),
        ("localize", run_folder, "--map", run_folder / "map.json"),
    ):
        assert is_refused(hopslam(*words), "config.yaml:", "slam.lines.method"), words
    for arguments in (
        ("report", run_folder),
        ("eval", run_folder, "--reference", run_folder / "odometry.tum"),
        ("export", run_folder, "--to", "ros", "--out", "map"),
        ("compare", run_folder, run_folder),
        ("view", run_folder, "--rerun", "run.rrd"),
    ):
        assert hopslam(*arguments)[0] == 0, arguments
    assert not gadget.exists()


def test_an_allowed_run_folder_is_replayed(run_folder: Path, gadget: Path) -> None:
    code, said = hopslam("replay", run_folder, "--allow-module", "gadget:find", "--out", "again")
    assert code == 0, said
    assert gadget.read_text().startswith("imported\ncalled ['cmd']\n")


def test_a_sweep_folder_keeps_no_permission(tmp_path: Path, gadget: Path) -> None:
    """The permission reaches the worker; to go on, or to repeat, needs it again."""
    file = write(tmp_path / "mine.yaml", {"extends": "umbmark_room", "duration": 0.5, "slam": {"lines": OWN}})
    code, said = hopslam("sweep", file, "--allow-module", "gadget", "--out", "swept", "--jobs", "1")
    assert (code, "1 runs done, 0 of them failed" in said) == (0, True), said
    assert gadget.read_text().startswith("imported\ncalled ['cmd']\n")
    gadget.unlink()
    again = ("sweep", "swept/sweep.yaml", "--out", "swept")
    for words in (again, (*again, "--plan"), ("sweep", "repeat", "swept", "")):
        assert is_refused(hopslam(*words), "mine.yaml:5: slam.lines.method"), words
    assert not gadget.exists()
    for kept in Path("swept").rglob("*.*"):
        assert not {b"allow_modules", b"allow-module"} & set(kept.read_bytes().split()), kept


@pytest.mark.parametrize(
    ("changes", "allowed"),
    [
        ({"settings": {"slam.lines.method": "gadget:find"}}, ["gadget:find"]),
        ({"settings": {"slam.lines": OWN}}, ["gadget:find"]),
        (
            {"grid": {"slam.matching.method": ["least_squares", "gadget:find", "gadget:run"]}},
            ["gadget:find", "gadget:run"],
        ),
        ({"sample": {"slam.lines.method": {"choice": ["paper", "gadget:find"]}}}, ["gadget:find"]),
        ({"settings": {"slam.lines.options.method": "gadget:find", "description": "gadget:find"}}, []),
    ],
)
def test_code_named_on_the_command_line_is_allowed(changes: dict[str, Any], allowed: list[str]) -> None:
    assert list(make_plan(["corridor"], changes).allowed) == allowed
    assert list(make_plan(["corridor"], changes, ["other"]).allowed) == ["other", *allowed]


def test_allowing_a_module_allows_its_definitions(tmp_path: Path, gadget: Path) -> None:
    """The gadget imports subprocess.run, which it does not define."""
    file = write(tmp_path / "evil.yaml", {"slam": {"lines": OWN | {"method": "gadget:run"}}})
    config = load_scenario(file, allow_modules=["gadget"]).slam.lines
    with pytest.raises(InputError, match="gadget:run comes from another module"):
        config.call(["touch", "pwned"])
    assert not Path("pwned").exists()


def test_python_code_allows_by_name_or_passes_functions(tmp_path: Path, gadget: Path) -> None:
    file = write(tmp_path / "mine.yaml", SCENARIOS["lines"])
    arguments = {"observe": ("slam_pose",), "end_on": ("collision",)}
    for allowed in ({"allow_modules": ("gadget",)}, {"settings": ["slam.lines.method=gadget:find"]}):
        env = gymnasium.make("sim:hopslam/P3DX-v0", scenario=file, **arguments, **allowed)
        env.reset(seed=1)
        env.close()
        assert "called" in gadget.read_text()
        gadget.unlink()
        sys.modules.pop("gadget")
    assert load_scenario(file, allow_modules=["gadget"]) == load_scenario(file, allow_modules=["gadget"])
    module = importlib.import_module("gadget")

    config = SlamConfig(lines=OwnMethod.of(module.find, cmd="ls"))
    assert LineSlam(config, Pose2D()).config.lines.method == "gadget:find"


@pytest.mark.parametrize(
    "scenario",
    [
        lambda file: read_scenario(file),
        lambda file: Scenario.model_validate(yaml.safe_load(file.read_text())),
        lambda file: Scenario.model_validate(load_scenario(file, allow_modules=["gadget"]).model_dump()),
    ],
    ids=["read", "validated", "dumped"],
)
def test_a_value_that_only_names_code_never_calls_it(scenario: Any, tmp_path: Path, gadget: Path) -> None:
    file = write(tmp_path / "evil.yaml", {"slam": {"lines": OWN}, "name": "evil"})
    config = scenario(file).slam
    with pytest.raises(InputError, match="a file may not run code, and gadget:find is code"):
        config.lines.call(None)
    assert not gadget.exists()


@pytest.mark.parametrize(
    "method", [" gadget:find", "gadget:find ", "gadget.find", "GADGET:find", "gadget:find\n", "::"]
)
def test_names_are_allowed_only_exactly(method: str, tmp_path: Path, gadget: Path) -> None:
    file = write(tmp_path / "evil.yaml", {"extends": "corridor", "slam": {"lines": {"method": method}}})
    with pytest.raises(ScenarioError, match=r"evil\.yaml:4: slam\.lines\.method"):
        load_scenario(file, allow_modules=["gadget"] if "GADGET" in method else [])
    assert not gadget.exists()


def test_yaml_tags_and_map_keys_create_no_objects(tmp_path: Path, gadget: Path, run_folder: Path) -> None:
    file = tmp_path / "evil.yaml"
    for tag in ("!!python/object/apply:gadget.find [1]", "!!python/name:gadget.find", "!!python/module:gadget"):
        file.write_text(f"extends: corridor\nname: {tag}\n")
        code, said = hopslam("run", file)
        assert (code, said.count("\n")) == (2, 0), said
    saved = json.loads((run_folder / "map.json").read_text())
    (tmp_path / "map.json").write_text(json.dumps(saved | {"method": "gadget:find", "py/object": "gadget.find"}))
    assert hopslam("localize", "corridor", "--map", tmp_path / "map.json")[0] == 2
    assert not gadget.exists()


def test_no_port_of_a_scenario_opens_a_file(tmp_path: Path) -> None:
    """pyserial's spy:// would write what it hears to any file."""
    file = write(tmp_path / "evil.yaml", {"extends": "corridor", "hardware": {"robot_port": "spy:///dev/null?file=x"}})
    with pytest.raises(ScenarioError, match=r"evil\.yaml:3: hardware\.robot_port: .*socket://"):
        load_scenario(file)
