"""Plan of a sweep from the arguments of ``hopslam sweep`` or from a sweep file."""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Final

from pydantic import ValidationError

from slam.errors import InputError, ScenarioError, did_you_mean
from slam.named_code import is_allowed, refusal
from slam.scenario.random_value import KINDS
from slam.scenario.settings import named_code, one_or_several
from slam.scenario.shipped import SHIPPED
from slam.scenario.validation_message import validation_message
from slam.scenario.yaml_file import YAML_ERRORS, KeyPath, YamlFile, explain_yaml_error, load_yaml
from slam.sweep.config import SweepConfig
from slam.sweep.plan import Plan

_CALL: Final = re.compile(r"\s*(\w+)\s*\((.*)\)\s*", re.DOTALL)


def make_plan(names: str | Sequence[str], changes: dict[str, Any], allow_modules: str | Sequence[str] = ()) -> Plan:
    """Plan the runs of scenarios and logs, or of one sweep file; ``changes`` override its keys.

    Code that ``changes`` name may run; code that files name may run if ``allow_modules`` has its module. InputError
    gives file, line and key of a fault in a file.
    """
    names = one_or_several(names)
    allowed = [*one_or_several(allow_modules), *(place for _, place in _code_in(changes))]
    files = [path for path in map(_sweep_file, names) if path is not None]
    if not files:
        return Plan(_config(_config_of_names(names) | changes, None), allowed=allowed)
    if len(names) > 1:
        raise InputError(f"{files[0]}: a sweep file must be the only argument; put the other scenarios into it")
    file = YamlFile(files[0])
    config = _config({"name": files[0].stem} | file.data | changes, file)
    _check_code(config, file, allowed)
    return Plan(config, files[0].parent, allowed)


def parse_grid(text: str) -> tuple[str, list[Any]]:
    """Parse ``key=a,b,c`` into key and values, each read as YAML."""
    key, value = _split("--grid", text, "slam.update_distance=0,0.1")
    return key, _yaml("--grid", text, f"[{value}]")


def parse_sample(text: str) -> tuple[str, dict[str, Any]]:
    """Parse ``key=uniform(0.2, 0.6)`` into key and the form of scenario files: ``{uniform: [0.2, 0.6]}``."""
    key, value = _split("--sample", text, "robot.start.y=uniform(-0.5,0.5)")
    call = _CALL.fullmatch(value)
    if call is None or call[1] not in KINDS:
        choices = ", ".join(f"{kind}(..)" for kind in KINDS)
        hint = did_you_mean(call[1] if call else "", KINDS, otherwise=f"choose one of {choices}")
        raise ScenarioError(f"--sample {text}: no distribution {value!r}; {hint}")
    return key, {call[1]: _yaml("--sample", text, f"[{call[2]}]")}


def _split(option: str, text: str, example: str) -> tuple[str, str]:
    key, equals, value = text.partition("=")
    if not equals or not all(key.strip().split(".")) or not value.strip():
        raise ScenarioError(f"{option} {text}: expected key=values, for example {option} {example}")
    return key.strip(), value


def _yaml(option: str, text: str, value: str) -> list[Any]:
    try:
        return list(load_yaml(value))
    except YAML_ERRORS as error:
        fault = f"the values are not valid YAML: {explain_yaml_error(error)[1]}; quote those that are text"
        raise ScenarioError(f"{option} {text}: {fault}") from error


def _sweep_file(name: str) -> Path | None:
    """Return the file with this path, or the shipped sweep with this name, if it is a sweep and not a scenario."""
    path = next((path for path in (Path(name), SHIPPED / "sweeps" / f"{name}.yaml") if path.is_file()), None)
    if path is None or path.suffix not in {".yaml", ".yml"}:
        return None
    return path if {"scenarios", "logs", "seeds"} & YamlFile(path).data.keys() else None


def _config_of_names(names: Sequence[str]) -> dict[str, Any]:
    """Make the configuration for these names; files that are not YAML are logs."""
    logs = [name for name in names if Path(name).is_file() and Path(name).suffix not in {".yaml", ".yml"}]
    scenarios = [name for name in names if name not in logs]
    stems = [re.sub(r"[^A-Za-z0-9._-]", "-", Path(name).name.split(".")[0].lstrip("-_")) or "sweep" for name in names]
    return {"scenarios": scenarios, "logs": logs, "name": "-".join(stems[:3])}


def _code_in(config: dict[str, Any]) -> Iterator[tuple[KeyPath, str]]:
    """Yield the ``module:name`` places in a sweep's configuration, each with its key."""
    values = [(part, key, value) for part in ("settings", "sample") for key, value in config.get(part, {}).items()]
    values += [("grid", key, value) for key, several in config.get("grid", {}).items() for value in several]
    for part, key, value in values:
        for place in named_code([(tuple(key.split(".")), value)]):
            yield (part, key), place


def _check_code(config: SweepConfig, file: YamlFile, allowed: Sequence[str]) -> None:
    for location, place in _code_in(config.model_dump()):
        if not is_allowed(place, allowed):
            raise ScenarioError(f"{file.place(location)}: {'.'.join(map(str, location))}: {refusal(place)}")


def _config(data: dict[str, Any], file: YamlFile | None) -> SweepConfig:
    try:
        return SweepConfig.model_validate(data)
    except ValidationError as errors:
        location, reason = validation_message(errors, SweepConfig)
        place = f"{file.place(location)}: " if file is not None and file.depth(location) else ""
        raise ScenarioError(f"{place}{'.'.join(map(str, location)) or 'sweep'}: {reason}") from errors
