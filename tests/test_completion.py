"""Completion of commands in the shells."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from slam.cli.main import app

HOPSLAM = Path(sys.executable).with_name("hopslam")


def offered(shell: str, line: str) -> list[str]:
    """Return the completions of the last word of a line."""
    words = line.split(" ")
    question = {
        "bash": {"COMP_WORDS": line, "COMP_CWORD": str(len(words) - 1)},
        "zsh": {"_TYPER_COMPLETE_ARGS": line},
        "fish": {"_TYPER_COMPLETE_ARGS": line, "_TYPER_COMPLETE_FISH_ACTION": "get-args"},
    }
    return asked(question[shell] | {"_HOPSLAM_COMPLETE": f"complete_{shell}"}).split()


def asked(environment: dict[str, str]) -> str:
    return CliRunner().invoke(app, [], env=environment, prog_name="hopslam").output


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_a_shipped_scenario_is_completed(shell: str) -> None:
    assert any("crowded_corridor" in word for word in offered(shell, "hopslam run cro"))


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("hopslam rep", ["replay", "repair", "report"]),
        ("hopslam run --allow", ["--allow-module"]),
        ("hopslam sweep run paper_v", ["paper_vs_ours"]),
        ("hopslam run no_such", []),
        ("hopslam run --start s", ["search"]),
    ],
)
def test_commands_options_and_choices_are_completed(line: str, words: list[str]) -> None:
    assert offered("bash", line) == words


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_script_of_each_shell_requests_completion(shell: str) -> None:
    assert f"_HOPSLAM_COMPLETE=complete_{shell}" in asked({"_HOPSLAM_COMPLETE": f"source_{shell}"})


def test_completion_is_installed_for_the_calling_shell(tmp_path: Path) -> None:
    home = os.environ | {"HOME": str(tmp_path)}
    subprocess.run(["bash", "-c", f"{HOPSLAM} --install-completion; true"], env=home, check=True, capture_output=True)
    line = "COMP_WORDS=(hopslam run cro) COMP_CWORD=2; _hopslam_completion hopslam; echo ${COMPREPLY[@]}"
    environment = home | {"PATH": f"{HOPSLAM.parent}:{os.environ['PATH']}"}
    offered = subprocess.run(
        ["bash", "--norc", "-c", f". {tmp_path}/.bashrc; {line}"], env=environment, capture_output=True, text=True
    )
    assert offered.stdout == "crowded_corridor\n", offered.stderr
