"""What a calibration found, as a scenario on top of another."""

from __future__ import annotations

from pathlib import Path

import yaml

from slam.errors import InputError
from slam.files.whole_files import write_whole
from slam.run.calibration.calibrate import Calibration, settings
from slam.scenario.schema import Scenario
from slam.scenario.shipped import find_scenario, shipped_scenarios


def check_onto(name: str) -> str:
    """What the file has to say in ``extends``: a shipped scenario's name, or a path; ScenarioError for neither."""
    path = find_scenario(name)
    return name if name in shipped_scenarios() and not Path(name).is_file() else str(path.resolve())


def write_wheels(path: Path, onto: str, scenario: Scenario, backend: str, found: Calibration) -> None:
    """Write the file; InputError where that is not possible."""
    squares = f"{len(found.laps)} squares against {found.against}"
    content = {
        "extends": onto,
        "description": f"{scenario.name}, its wheels calibrated by {squares}",
    } | settings(scenario, backend, found.fit)
    errors = found.errors
    note = (
        f"# Two standard errors of the factors, from square to square: left wheel {2.0 * errors.left:.5f}, right wheel "
        f"{2.0 * errors.right:.5f}, track {2.0 * errors.track:.5f}.\n"
    )
    try:
        write_whole(path, note + yaml.safe_dump(content, sort_keys=False, allow_unicode=True))
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}; choose another --out FILE") from error
