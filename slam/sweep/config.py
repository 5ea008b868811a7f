"""Configuration of a sweep: schema of its YAML file, and of the options of ``hopslam sweep``."""

from collections import Counter
from math import prod
from typing import Annotated, Any, Self

from pydantic import AfterValidator, BeforeValidator, Field, ValidationError, model_validator

from slam.config import Section
from slam.limits import CASES, RUNS
from slam.modes import ModeName
from slam.scenario.random_value import KINDS, is_random
from slam.scenario.validation_message import error_message


def _parse_range(given: Any) -> Any:
    """Parse ``0:100`` as the numbers from 0 to 99, and one number as a list of it."""
    if isinstance(given, int):
        return [given]
    if not isinstance(given, str):
        return given
    first, _, end = given.partition(":")
    try:
        seeds = range(int(first), int(end) if end else int(first) + 1)
    except ValueError:
        raise ValueError("expected first:end, for example 0:100, which ends with 99, or a list of numbers") from None
    if excess := RUNS.excess(seeds.stop - seeds.start):
        raise ValueError(excess)
    return list(seeds)


def _check_distribution(given: Any) -> Any:
    if not is_random(given):
        raise ValueError(f"expected one of {', '.join(KINDS)} with its numbers, for example {{uniform: [0.2, 0.6]}}")
    kind = KINDS[next(iter(given))]
    try:
        kind.model_validate(given)
    except ValidationError as errors:
        raise ValueError(error_message(errors.errors()[0], kind)[1]) from errors
    return given


def _check_unique(values: tuple[Any, ...]) -> tuple[Any, ...]:
    if excess := CASES.excess(len(values)):
        raise ValueError(excess)
    doubles = [value for index, value in enumerate(values) if value in values[:index]]
    if doubles:
        raise ValueError(f"{doubles[0]} stands here twice")
    return values


def _check_seeds(seeds: tuple[int, ...]) -> tuple[int, ...]:
    counts = Counter(seeds)
    if len(counts) < len(seeds):
        raise ValueError(f"{counts.most_common(1)[0][0]} stands here twice")
    return seeds


Seeds = Annotated[
    tuple[Annotated[int, Field(ge=0)], ...],
    BeforeValidator(_parse_range),
    AfterValidator(_check_seeds),
    Field(min_length=1),
]
Values = Annotated[tuple[Any, ...], AfterValidator(_check_unique), Field(min_length=1)]


class SweepConfig(Section):
    """Scenario x mode x grid x seed: each combination is one run."""

    name: str = Field("sweep", pattern=r"^[A-Za-z0-9][A-Za-z0-9._ -]*$")
    """Name of the sweep's folder."""
    description: str = ""
    scenarios: Annotated[tuple[str, ...], AfterValidator(_check_unique)] = ()
    """Scenarios: shipped ones by name, others by path, relative to the sweep's file."""
    logs: Annotated[tuple[str, ...], AfterValidator(_check_unique)] = ()
    """Recorded logs, by path."""
    modes: Annotated[tuple[ModeName, ...], AfterValidator(_check_unique)] = ()
    """Modes of the method; empty: the mode of each scenario. If a scenario has another mode than the run, the run does
    not use its section ``slam``, but the defaults of the run's mode; for the paper's mode, the section ``slam`` of
    ``paper_corridor``, or of ``paper_replay`` for a log."""
    seeds: Seeds = (0,)
    """Seeds: ``first:end``, which does not include the end, or a list."""
    grid: dict[str, Values] = Field({})
    """Settings such as ``slam.matching.floor``, each with the values that are tried."""
    sample: dict[str, Annotated[Any, AfterValidator(_check_distribution)]] = Field({})
    """Settings that are drawn for each seed: ``{uniform: [low, high]}`` and the like, as in scenarios."""
    settings: dict[str, Any] = Field({})
    """Settings of all runs."""
    seed: int = Field(0, ge=0)
    """Seed of the sampled settings, together with a run's own seed."""

    @model_validator(mode="after")
    def _something_to_run(self) -> Self:
        if not self.scenarios and not self.logs:
            raise ValueError("nothing to run; name at least one scenario or log")
        return self

    @model_validator(mode="after")
    def _not_too_many(self) -> Self:
        inputs, modes = len(self.scenarios) + len(self.logs), max(len(self.modes), 1)
        cases = inputs * modes * prod(map(len, self.grid.values()))
        if excess := CASES.excess(cases) or RUNS.excess(cases * len(self.seeds)):
            raise ValueError(excess)
        return self

    @model_validator(mode="after")
    def _each_setting_once(self) -> Self:
        keys = [*self.grid, *self.sample, *self.settings]
        if {"slam", "slam.mode"} & set(keys):
            raise ValueError(
                "slam.mode cannot be set here: use modes (--mode); a whole section slam belongs into a scenario"
            )
        doubles = {key for key in keys if keys.count(key) > 1} | {"seed"} & set(keys)
        if doubles:
            raise ValueError(f"{min(doubles)} is set in two ways; leave it in one of seeds, grid, sample, settings")
        return self
