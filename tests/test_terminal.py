"""Printed text is complete, without line breaks inside words and without markup, on any output."""

from __future__ import annotations

import ast
import re
import shlex
import shutil
from io import StringIO
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from typer.testing import CliRunner

from slam.cli.compare import _cells
from slam.cli.main import app
from slam.console.result_table import ResultTable
from slam.console.terminal import Terminal
from slam.console.terminal_table import TerminalTable
from slam.errors import InputError
from slam.run.run_and_report import summary_tables
from slam.run.watchers import RunProgress
from slam.sweep.launch import Sweep
from slam.sweep.report.write import write_report

ROOT = Path(__file__).parents[1]
WILD = "[/x] [m] [bold]b[/bold] :smile: [link=a]"


def shown(*tables: TerminalTable, width: int | None = None) -> str:
    """Return these tables as printed on a terminal of ``width`` characters, without colours, or in a file."""
    text = StringIO()
    Terminal(file=text, width=width, force_terminal=width is not None).print(*tables)
    return re.sub(r"\x1b\[[0-9;]*m", "", text.getvalue())


def test_only_the_terminal_modules_know_rich() -> None:
    """Text printed in any other module would have its brackets read as markup."""
    for path in (path for package in ("sim", "slam", "hardware") for path in (ROOT / package).rglob("*.py")):
        nodes = list(ast.walk(ast.parse(path.read_text())))
        modules = {alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names}
        modules |= {str(node.module) for node in nodes if isinstance(node, ast.ImportFrom)}
        known = path.name in {"terminal.py", "terminal_table.py"}
        assert known or not any(name.split(".")[0] == "rich" for name in modules), path


words = st.text("abc[]/:m.0123456789-", min_size=1, max_size=9)
cells = st.one_of(words, st.lists(words, min_size=1, max_size=8).map(" ".join))


@given(st.integers(1, 7).flatmap(lambda n: st.lists(st.lists(cells, min_size=n, max_size=n), min_size=2, max_size=5)))
def test_a_table_in_a_file_has_each_row_in_one_line(rows: list[list[str]]) -> None:
    lines = shown(TerminalTable(rows[0], rows[1:])).splitlines()
    assert [line.split() for line in (lines[0], *lines[2:])] == [" ".join(row).split() for row in rows]


@given(
    st.integers(1, 7).flatmap(lambda n: st.lists(st.lists(cells, min_size=n, max_size=n), min_size=2, max_size=5)),
    st.integers(40, 120),
)
def test_a_table_on_a_terminal_breaks_no_word_and_fits(rows: list[list[str]], width: int) -> None:
    text = shown(TerminalTable(rows[0], rows[1:], "title of it", "some notes on what is told here"), width=width)
    assert {word for row in rows for cell in row for word in cell.split()} <= set(text.split())
    assert max(map(len, text.splitlines())) <= max(width, 50)  # two columns of 24 are the least


def test_numbers_are_not_broken_at_any_width() -> None:
    numbers = [f"{10**k + 0.2:.1f}" for k in range(8)]
    table = ResultTable(
        "T [m]", ["method", *(f"column {k}\n[deg]" for k in range(8))], [["RANSAC, long name", *numbers]]
    )
    for width in (*range(20, 140, 7), None):
        text = shown(table.for_terminal(), width=width)
        assert set(numbers) <= set(text.split()), width
        assert text.count("[deg]") == 8


METRICS = {
    **{f"{who}{key}": 1.0 for who in ("", "odometry_") for key in (
        "ate_rmse_m", "ate_max_m", "final_m", "x_max_abs_m", "y_max_abs_m", "heading_rmse_deg", "heading_max_abs_deg")},
    "scans": 9, "updates": 8, "path_m": 1.0, "duration_s": 1.0, "real_time_factor": 1.0, "iterations_mean": 1.0,
    "iterations_max": 2, "not_converged": 0, "odometry_only": 0, "odometry_only_share": 0.0,
    "slam_ms_median": 1.0, "slam_ms_p99": 1.0, "map_points": 1, "segments": 1,
    "lost_scans": 0, "sure_after_s": 1.0,
}  # fmt: skip


@pytest.mark.parametrize("width", [None, 80, 40])
def test_the_summary_of_a_run_has_its_units(width: int | None) -> None:
    text = shown(*summary_tables(METRICS), width=width)
    assert (text.count("[m]"), text.count("[deg]")) in {(5, 2), (10, 4)}  # one table, or two below each other
    for unit in ("1.0 m,", "1.0 s", "1.00 ms"):
        assert unit in text


@pytest.mark.parametrize(("named", "end"), [({}, ""), ({"named_range_noise_m": 0.003}, "; as named: 3 mm")])
def test_the_summary_reports_the_learned_noise(named: dict[str, float], end: str) -> None:
    text = shown(*summary_tables(METRICS | {"range_noise_m": 0.008, "range_noise_share": 0.008} | named))
    assert f"8 mm, 0.8 % beyond 1.0 m{end}" in text


def test_messages_are_printed_unchanged() -> None:
    text = StringIO()
    terminal = Terminal(file=text, width=300, force_terminal=True)
    terminal.print(WILD)
    with terminal.waiting(WILD):
        pass
    with RunProgress(terminal, WILD), pytest.raises(ZeroDivisionError):
        raise ZeroDivisionError
    assert text.getvalue().count(WILD) >= 3


def test_a_pipe_gets_no_progress(capsys: pytest.CaptureFixture[str]) -> None:
    terminal = Terminal()
    with terminal.progress() as bar, terminal.waiting("wait"):
        for _ in bar.track(range(3), description="long work"):
            pass
    assert capsys.readouterr() == ("", "")


def test_a_run_prints_a_path_in_brackets(tmp_path: Path) -> None:
    out = tmp_path / "out[/x] [m]"
    done = CliRunner().invoke(app, ["run", "corridor", "--set", "duration=1", "--out", str(out)])
    assert done.exit_code == 0, done.output
    assert f"results in {out}" in done.output
    other = shutil.copytree(out, out.with_name("[bold]b"))
    compared = CliRunner().invoke(app, ["compare", str(out), str(other)])
    assert compared.output.splitlines()[0].split() == ["x]", "[m]", "[bold]b"]


@pytest.mark.parametrize(
    ("value", "first", "text"),
    [
        (97.3, 0.1, "97.3 (x 973)"), (0.1, 97.3, "0.1 (/ 973)"), (1.1, 1.0, "1.1 (+10 %)"),
        (0.9, 1.0, "0.9 (-10 %)"), (3, 0, "3 (+3)"), (-1.0, 1.0, "-1 (-2)"), (1, 1, "1"), ("a", "b", "a"),
        (None, 1.0, "-"), (True, False, "True"),
    ],
)  # fmt: skip
def test_a_difference_is_a_share_or_a_factor(value: object, first: object, text: str) -> None:
    assert _cells([first, value])[1] == text


def test_a_quiet_console_shows_no_progress_bar(capsys: pytest.CaptureFixture[str]) -> None:
    console = Terminal(quiet=True, force_jupyter=True)  # in a notebook, where rich shows widgets
    with console.waiting("for it"), console.progress() as bar:
        bar.advance(bar.add_task("it", total=1.0))
    with pytest.warns(UserWarning, match="strange"):
        console.warn("strange")
    assert capsys.readouterr() == ("", "")


def command_in(text: str) -> list[str]:
    """The words that a shell makes of the command at the end of a message."""
    return shlex.split("hopslam" + text.strip().rpartition("hopslam")[2])


def test_a_printed_command_can_be_pasted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = str(tmp_path / "my sweep [1]; $(true) 'x'")
    with pytest.raises(InputError) as raised:
        write_report(out)
    assert command_in(str(raised.value)) == ["hopslam", "sweep", "SCENARIO", "--out", out]
    monkeypatch.setattr("slam.sweep.launch.sweep", lambda *_, **given: Sweep(given["out"], done=1))
    done = CliRunner().invoke(app, ["sweep", "paper_simulation", "--out", out])
    assert command_in(done.output) == ["hopslam", "sweep", "report", out]
