"""README and docs match the code: commands and code run, YAML is valid, links exist."""

import gzip
import re
import shlex
import shutil
import tomllib
from collections.abc import Iterator
from functools import cache
from itertools import chain
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import yaml
from typer.main import get_command
from typer.testing import CliRunner

from slam.cli.main import app
from slam.env.ids import ENV_IDS
from slam.scenario.file import checked_template, load_scenario
from slam.scenario.json_schema import scenario_schema
from slam.scenario.shipped import shipped_scenarios
from slam.sweep.make_plan import make_plan

ROOT = Path(__file__).parents[1]
WRITTEN = sorted((ROOT / "docs").rglob("*.md"))
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *WRITTEN]
FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)

PARSED_ONLY = {
    r"--backend hardware": "needs a robot",
    r"--rerun (spawn|serve|connect)|hopslam view( runs/latest)?$": "opens a window, or serves until Ctrl-C",
    r"hopslam (doctor|emulate)": "looks for devices, or emulates them until Ctrl-C; tests/test_hardware_cli.py",
    r"hopslam ros|--backend ros": "needs a robot of ROS 2; make test-ros",
    r"--(foxglove|ros)\b": "serves topics; tests/test_foxglove.py, tests/test_ros_bus.py",
    r"hopslam wire": "needs a recording; tests/test_wire.py",
    r"hopslam calibrate": "drives for minutes; tests/test_calibration.py",
    r"hopslam bench": "measures for minutes; tests/test_bench_*.py",
    r"hopslam sweep": "many runs in processes of their own; tests/test_sweep_*.py",
    r"--figures": "draws for seconds; tests/test_pictures.py",
    r"--scan-topic": "needs a bag with other topics; tests/test_bags.py",
}
"""Commands that are not run, with the reason; their options and settings are checked all the same."""
FASTER = {"run": ["--set", "duration=1"], "localize": ["--set", "duration=1"], "animate": ["--seconds", "1"]}
"""Arguments that make a command short."""
SMALLER = {r"--scan \d+": "--scan 5", r"/tmp/": "tmp/"}
"""Replacements in the commands: the small log has few scans, and lies in a folder of the test."""
NOT_OURS = {"rerun", "ssh", "ray", "export", "ros2", "rviz2"}
"""First words of the commands of other programs."""


@pytest.fixture(scope="module")
def prepared(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the files that the pages speak of, all of one short run."""
    folder = tmp_path_factory.mktemp("docs")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        invoke(["run", "random_office", "--seed", "7", "--set", "duration=1", "--out", "runs/before"])
        invoke(["export", "runs/before", "--to", "carmen", "--out", "office.log"])
    for name in ("runs/after", "runs/corridor-1", "first_half"):
        shutil.copytree(folder / "runs/before", folder / name)
    (folder / "runs/latest").symlink_to("before")
    for name in ("second_half.log", "fr079.log.gz", "mines1.dat.gz"):
        shutil.copy(folder / "office.log", folder / name)
    shutil.copy(folder / "runs/before/groundtruth.tum", folder / "fr079.gt.tum")
    stamps = [line.split()[0] for line in (folder / "fr079.gt.tum").read_text().splitlines()]
    (folder / "fr079.relations.gz").write_bytes(gzip.compress(f"{stamps[0]} {stamps[-1]} 0 0 0 0 0 0\n".encode()))
    (folder / "map.pgm").write_bytes(b"P5 2 2 255 " + bytes([0, 255, 255, 255]))
    (folder / "map.yaml").write_text("image: map.pgm\nresolution: 0.05\norigin: [-9, -9, 0]\nnegate: 0\n")
    (folder / "my_room.yaml").write_text("extends: cluttered_room\n")
    (folder / "docs").mkdir()
    return folder


@pytest.mark.usefixtures("no_pictures")
@pytest.mark.parametrize("page", PAGES, ids=[page.stem for page in PAGES])
def test_every_code_block_of_a_page_runs(
    page: Path, prepared: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copytree(prepared, tmp_path, symlinks=True, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    blocks = FENCE.findall(page.read_text())
    for _, text in blocks:
        if (file := re.match(r"# (\w+\.(?:py|yaml))\n", text)) is not None:
            Path(file[1]).write_text(text)
    for language, text in blocks:
        if language == "python":
            run_python(text, page)
        elif language == "yaml":
            check_yaml(text)
        elif language == "sh" or "\nhopslam " in f"\n{text}" or "\nmake " in f"\n{text}":
            Path("runs/latest").unlink()  # every block begins with the prepared run
            Path("runs/latest").symlink_to("before")
            for line in text.replace("\\\n", " ").splitlines():
                run_line(line)


def run_python(text: str, page: Path) -> None:
    code = compile(text, str(page), "exec")
    if "# not run by the tests" not in text:
        exec(code, {"__name__": "__main__"})


@cache
def schema() -> jsonschema.Draft202012Validator:
    return jsonschema.Draft202012Validator(scenario_schema())


def check_yaml(text: str) -> None:
    Path("block.yaml").write_text(text)
    if "scenarios" in (data := yaml.safe_load(text)):
        assert len(make_plan(["block.yaml"], {}))
    else:
        schema().validate(data)
        checked_template("block.yaml", [], None).draw(1)


def run_line(line: str) -> None:
    words = words_of(re.sub(r"^\w+\$ |^(\w+=\S+ )+", "", line))
    if not words or words[0] in NOT_OURS:
        return
    program, *rest = words
    if program == "make":
        assert re.search(rf"^{rest[0]}:", (ROOT / "Makefile").read_text(), re.MULTILINE), line
    elif program == "pip":
        extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
        assert rest[-1] in {f"hopslam[{extra}]" for extra in extras}, line
    elif program == "python":
        assert (ROOT / rest[0]).is_file(), line
    else:
        assert program == "hopslam", line
        if any(re.search(pattern, shlex.join(words)) for pattern in PARSED_ONLY):
            parse(rest)
        else:
            invoke(smaller(rest))


def words_of(text: str) -> list[str]:
    """Split a command into words, over several lines, without pipes and redirections."""
    return shlex.split(re.split(r" [|>] ", " ".join(text.split()))[0], comments=True)


def smaller(words: list[str]) -> list[str]:
    line = " ".join(map(shlex.quote, words))
    for pattern, short in SMALLER.items():
        line = re.sub(pattern, short, line)
    found = (sorted(map(str, Path().glob(word))) if "*" in word else [word] for word in shlex.split(line))
    return [*chain.from_iterable(found), *FASTER.get(words[0], [])]


def invoke(words: list[str]) -> None:
    result = CliRunner().invoke(app, words)
    assert result.exit_code == 0, f"hopslam {shlex.join(words)}: {result.exception!r}\n{result.output}"


def parse(words: list[str]) -> None:
    """Check that the command takes these options, and that a shipped scenario takes these settings."""
    given = dry_app().main(args=list(words), prog_name="hopslam", standalone_mode=False)
    if isinstance(given, dict) and given.get("scenario") in shipped_scenarios():
        load_scenario(given["scenario"], given.get("settings") or [])


@cache
def dry_app() -> Any:
    """The command line, whose commands return what they were given."""
    tree = get_command(app)
    for leaf in leaves(tree):
        leaf.callback = lambda **given: given
    return tree


def leaves(command: Any) -> Iterator[Any]:
    if not hasattr(command, "commands"):
        yield command
    for inner in getattr(command, "commands", {}).values():
        yield from leaves(inner)


def test_the_commands_in_the_text_take_their_options() -> None:
    commands = get_command(app).commands
    for page in PAGES:
        for text in re.findall(r"`(hopslam [a-z][^`]*)`", FENCE.sub("", page.read_text())):
            name, *words = words_of(text)[1:]
            assert name in commands, f"{page.name}: {text}"
            if words:
                parse([name, *words])


def test_the_examples_in_the_help_take_their_options() -> None:
    for leaf in leaves(get_command(app)):
        examples = re.findall(r"^hopslam .*(?:\n\S.*)*", leaf.help, re.MULTILINE)
        assert examples, leaf.name
        for text in examples:
            parse(words_of(text)[1:])


def test_links_and_pictures_exist() -> None:
    for page in PAGES:
        for target in re.findall(r"\]\(([^)#\s]+)[^)]*\)", FENCE.sub("", page.read_text())):
            made = target.startswith(("https:", "reference/"))
            assert made or (page.parent / target).exists(), f"{page.name}: {target}"


def test_names_exist_in_the_files_that_pages_cite() -> None:
    for page in PAGES:
        for name, path in re.findall(r"`(\w+)`\s+(?:in|of)\s+`([\w/]+/\w+\.py)`", page.read_text()):
            code = (ROOT / path).read_text()
            assert re.search(rf"^(def |class )?{name}\b", code, re.MULTILINE), f"{page.name}: {name} in {path}"


def test_the_navigation_of_the_site_has_every_page() -> None:
    paths = set(re.findall(r"[\w/.-]+\.md$", (ROOT / "mkdocs.yml").read_text(), re.MULTILINE))
    written = {str(page.relative_to(ROOT / "docs")) for page in WRITTEN}
    assert {path for path in paths if "reference/" not in path} == written | {
        "index.md",
        "contributing.md",
        "changelog.md",
    }


def test_the_page_on_the_environment_lists_every_id() -> None:
    page = (ROOT / "docs/env.md").read_text()
    assert set(re.findall(r"^\| `(hopslam/\S+)`", page, re.MULTILINE)) == set(ENV_IDS)
