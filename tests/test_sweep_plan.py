"""The plan of a sweep: its runs, counted before any is started."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slam.errors import HopslamError
from slam.scenario.file import load_scenario
from slam.sweep.config import SweepConfig
from slam.sweep.job import format_setting
from slam.sweep.make_plan import make_plan, parse_grid, parse_sample
from slam.sweep.plan import Plan

PSI, FLOOR = "slam.lines.psi", "slam.matching.floor"


def plan(**changes: object) -> Plan:
    return make_plan(["paper_simulation"], {"seeds": "0:3", **changes})


def ids(**changes: object) -> list[str]:
    return [job.id for job in plan(**changes).jobs()]


@given(st.one_of(st.floats(allow_nan=False, allow_infinity=False), st.integers(), st.booleans(), st.text("ab:{}, #")))
def test_a_setting_is_read_back_as_the_same_value(value: object) -> None:
    """``--set`` reads the text back with all digits, although YAML would round or retype it."""
    from slam.scenario.settings import parse_setting

    assert parse_setting(format_setting("route.speed", value)) == (("route", "speed"), value)


def test_runs_of_a_sweep_differ_and_repeat() -> None:
    made = ids(modes=["hopslam", "paper"], grid={"route.speed": [0.3, 0.4]})
    assert len(set(made)) == len(made) == 12 == len(plan(modes=["hopslam", "paper"], grid={"route.speed": [0.3, 0.4]}))
    assert made == ids(modes=["hopslam", "paper"], grid={"route.speed": [0.3, 0.4]})
    assert set(ids()) < set(ids(seeds="0:5"))
    assert not set(ids()) & set(ids(settings={"duration": 5}))


def test_a_changed_scenario_makes_another_run(tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    made = []
    for speed in (0.3, 0.3, 0.4):
        file.write_text(f"extends: paper_simulation\nroute: {{speed: {speed}}}\n")
        made.append(next(make_plan([str(file)], {}).jobs()).id)
    assert made[0] == made[1] != made[2]


def test_the_settings_of_a_job_make_a_scenario_of_its_mode() -> None:
    modes = ["hopslam", "paper", "dead_reckoning"]
    for name in ("corridor", "paper_simulation"):
        for job in make_plan([name], {"modes": modes}).jobs():
            assert load_scenario(job.source, job.settings).slam.mode == job.mode
    own = list(make_plan(["corridor", "paper_simulation"], {}).jobs())
    assert [(job.mode, job.settings) for job in own] == [("hopslam", ()), ("paper", ())]


def test_sampled_settings_depend_only_on_the_seed() -> None:
    sample = {"robot.odometry.travel_noise": {"loguniform": [1e-3, 1e-1]}}
    jobs = list(plan(modes=["hopslam", "paper"], sample=sample).jobs())
    drawn = {(job.seed, job.drawn["robot.odometry.travel_noise"]) for job in jobs}
    assert len(jobs) == 6
    assert len(drawn) == len({value for _, value in drawn}) == 3
    assert all(1e-3 <= value <= 1e-1 for _, value in drawn)
    assert drawn != {(j.seed, *j.drawn.values()) for j in plan(sample=sample, seed=1).jobs()}


def test_options_of_a_sweep_are_read() -> None:
    assert parse_grid("a.b=1,x,[2,3],1e-3") == ("a.b", [1, "x", [2, 3], "1e-3"])
    assert parse_sample("a=normal(0, 0.1)") == ("a", {"normal": [0, 0.1]})
    assert parse_sample("a=choice(x,[1,2])") == ("a", {"choice": ["x", [1, 2]]})


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"grid": {"slam.lines.psy": [1]}}, "did you mean psi?"),
        ({"sample": {PSI: {"uniform": [0, -1]}}}, "the lower bound comes first"),
        ({"sample": {"route.speed": {"uniform": [-1, 1]}}}, "greater than 0"),
        ({"sample": {PSI: 3}}, "expected one of uniform"),
        ({"seeds": "a:b"}, "expected first:end"),
        ({"seeds": "3:3"}, "seeds"),
        ({"modes": ["ours"]}, "modes.0"),
        ({"grid": {"slam.mode": ["paper"]}}, "--mode"),
        ({"grid": {PSI: [1]}, "settings": {PSI: 2}}, "set in two ways"),
    ],
)
def test_mistakes_are_reported_before_any_run(changes: dict[str, object], complaint: str) -> None:
    with pytest.raises(HopslamError, match=complaint.replace("?", r"\?")):
        plan(**changes).check()


def test_a_fault_in_a_sweep_file_has_its_line(tmp_path: Path) -> None:
    file = tmp_path / "many.yaml"
    file.write_text("scenarios: [corridor]\nseeds: 0:2\ngrid:\n  route.speed: []\n")
    with pytest.raises(HopslamError, match=r"many.yaml:4: grid.route.speed"):
        make_plan([str(file)], {})
    file.write_text("scenarios: [corridor]\nseed: 0\nseedz: 0:2\n")
    with pytest.raises(HopslamError, match=r"many.yaml:3: seedz: unknown key; did you mean seed"):
        make_plan([str(file)], {})


@pytest.mark.parametrize("text", ["a", "=1", "a=", "a=[1"])
def test_invalid_options_are_refused(text: str) -> None:
    with pytest.raises(HopslamError, match="--grid"):
        parse_grid(text)
    with pytest.raises(HopslamError, match="--sample"):
        parse_sample(text)


def test_shipped_sweeps_can_be_run() -> None:
    shipped = make_plan(["paper_vs_ours"], {})
    shipped.check()
    assert set(shipped.config.modes) == {"hopslam", "paper", "dead_reckoning"}


def test_the_schema_describes_a_sweep_file() -> None:
    assert {"scenarios", "modes", "seeds", "grid", "sample"} <= SweepConfig.model_json_schema()["properties"].keys()
