"""``hopslam env``."""

import pytest
from typer.testing import CliRunner

from slam.cli.main import app
from slam.env.ids import ENV_IDS
from slam.errors import InputError

runner = CliRunner(env={"COLUMNS": "200"})


def test_the_list_has_every_id_with_a_description() -> None:
    out = runner.invoke(app, ["env"]).output
    assert all(env_id in out for env_id in ENV_IDS)
    assert "A 35 m corridor" in out


@pytest.mark.parametrize("name", ["hopslam/PaperSimulation-v0", "PaperSimulation-v0"])
def test_the_manual_is_the_docstring_with_the_spaces_as_built(name: str) -> None:
    out = runner.invoke(app, ["env", name]).output
    assert "hopslam/PaperSimulation-v0" in out
    assert "Version History" in out
    assert "Box(0.0, 4.0, (128,), float32)" in out
    assert "vector_entry_point" in out
    assert "number of robots" in out
    assert "6 control steps of 4 physics steps of 1/240 s" in out


def test_an_unknown_id_is_an_error() -> None:
    result = runner.invoke(app, ["env", "Coridor-v0"])
    assert isinstance(result.exception, InputError)
    assert "did you mean hopslam/Corridor-v0?" in str(result.exception)
