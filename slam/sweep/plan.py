"""All runs of a sweep, generated one after another."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

from slam.errors import InputError, ScenarioError
from slam.scenario.file import checked_template
from slam.scenario.random_value import KINDS, key_rng
from slam.sweep.config import SweepConfig
from slam.sweep.job import Job, format_setting
from slam.sweep.sweep_input import SweepInput


@dataclass(frozen=True, slots=True)
class Case:
    """An input in a mode, with one combination of the grid: each seed makes one run of it."""

    input: SweepInput
    mode: str
    grid: dict[str, Any]
    settings: tuple[str, ...]
    """Settings of the run, except those drawn for each seed."""

    @property
    def label(self) -> str:
        """Name for a table: input, mode, and the settings of the grid."""
        return ", ".join([self.input.name, self.mode, *(format_setting(*item) for item in self.grid.items())])


class Plan:
    """The runs of this configuration; its files are relative to ``beside``. InputError for a missing one.

    ``allowed`` are the modules and ``module:name`` places whose code the user allows; they are not written to a file.
    """

    def __init__(self, config: SweepConfig, beside: Path = Path(), allowed: Sequence[str] = ()) -> None:
        self.config = config
        self.allowed = tuple(allowed)
        self.inputs = [SweepInput.from_scenario(name, beside) for name in config.scenarios]
        self.inputs += [SweepInput.from_log(name, beside) for name in config.logs]
        self.cases = [case for input_ in self.inputs for case in self._cases_of(input_)]

    def __len__(self) -> int:
        return len(self.cases) * len(self.config.seeds)

    def jobs(self) -> Iterator[Job]:
        """Yield jobs seed by seed, so that a sweep stopped half way has tried all cases equally."""
        return (self.job(case, seed) for seed in self.config.seeds for case in self.cases)

    def job(self, case: Case, seed: int) -> Job:
        """Make the job of one case with one seed; drawn settings are the same in all cases, for comparison."""
        kinds = {key: KINDS[next(iter(text))].model_validate(text) for key, text in self.config.sample.items()}
        drawn = {key: kind.draw(key_rng((key,), self.config.seed, seed)) for key, kind in kinds.items()}
        return Job.create(
            case.input.digest,
            kind=case.input.kind,
            name=case.input.name,
            source=case.input.source,
            mode=case.mode,
            seed=seed,
            grid=case.grid,
            drawn=drawn,
            settings=(*case.settings, *(format_setting(*item) for item in drawn.items())),
        )

    def files(self) -> list[Path]:
        """Files that the runs need in addition to hopslam."""
        return [path for input_ in self.inputs for path in input_.files]

    def check(self) -> None:
        """Raise ScenarioError if a setting of a case is wrong; sampled ones are checked at both ends of their range."""
        sampled = [format_setting(*item) for item in self.config.sample.items()]
        for case in self.cases:
            try:
                checked_template(case.input.scenario, [*case.settings, *sampled], self.allowed)
            except ScenarioError as error:
                raise InputError(f"{case.label}: {error}") from error

    def _cases_of(self, input_: SweepInput) -> Iterator[Case]:
        common = [format_setting(*item) for item in self.config.settings.items()]
        for mode in self.config.modes or (input_.mode,):
            for values in product(*self.config.grid.values()):
                grid = dict(zip(self.config.grid, values, strict=True))
                tried = [format_setting(*item) for item in grid.items()]
                yield Case(input_, mode, grid, (*input_.mode_settings(mode), *common, *tried))
