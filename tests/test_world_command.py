"""``hopslam world``, and the list of generators in the documentation."""

import re
import sys
from pathlib import Path

import pytest

from slam.cli.main import main
from slam.scenario.shipped import shipped_scenarios

PAGE = Path(__file__).parents[1] / "docs" / "scenarios.md"


def run(*words: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["hopslam", *words])
    main()


@pytest.mark.parametrize("name", shipped_scenarios())
def test_every_shipped_scenario_can_be_drawn(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    picture = tmp_path / "plan.png"
    with pytest.raises(SystemExit, match="0"):
        run("world", name, "--out", str(picture), monkeypatch=monkeypatch)
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert capsys.readouterr().out.startswith(f"{name}: ")


def test_a_seed_and_settings_are_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit, match="0"):
        run("world", "random_office", "--seed", "7", "--set", "name=seven", monkeypatch=monkeypatch)
    said = capsys.readouterr().out
    assert "seed 7" in said
    assert re.search(r"world: \d+\.\d m by \d+\.\d m, \d+ solids, \d+ of them cut by the lidar's plane at 0\.3 m", said)
    assert (tmp_path / "seven.png").is_file()


@pytest.mark.parametrize("out", ["plan.txt", "no/such/folder/plan.png"])
def test_a_picture_that_cannot_be_written_is_refused(
    out: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit, match="2"):
        run("world", "corridor", "--out", out, monkeypatch=monkeypatch)
    error = capsys.readouterr().err
    assert error.startswith(f"hopslam: {out}: ")
    assert error.count("\n") == 1


def test_the_page_names_every_parameter_of_the_generators() -> None:
    from slam.scenario.generators.campus import CampusGenerator
    from slam.scenario.generators.corridor import CorridorGenerator
    from slam.scenario.generators.loop import LoopGenerator
    from slam.scenario.generators.office import OfficeGenerator

    page = PAGE.read_text()
    for generator in (CampusGenerator, CorridorGenerator, LoopGenerator, OfficeGenerator):
        assert [name for name in generator.model_fields if f"`{name}`" not in page] == []
