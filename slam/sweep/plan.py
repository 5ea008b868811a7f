"""All runs of a sweep, one after another, made when they are asked for."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

from slam.errors import InputError, ScenarioError
from slam.scenario.file import checked_template
from slam.scenario.random_value import KINDS, key_rng
from slam.sweep.config import SweepConfig
from slam.sweep.job import Job, setting
from slam.sweep.sweep_input import SweepInput


@dataclass(frozen=True, slots=True)
class Case:
    """What the seeds are tried on: a subject in a mode, with one combination of the grid."""

    subject: SweepInput
    mode: str
    grid: dict[str, Any]
    settings: tuple[str, ...]
    """All but those that are drawn."""

    @property
    def label(self) -> str:
        """In a table: name, mode, and the settings of the grid."""
        return ", ".join([self.subject.name, self.mode, *(setting(*item) for item in self.grid.items())])


class Plan:
    """The runs of this configuration; files named in it are relative to ``beside``. InputError where one is missing.

    ``allowed`` are the modules and ``module:name`` places whose code the user allows. It is written to no file.
    """

    def __init__(self, config: SweepConfig, beside: Path = Path(), allowed: Sequence[str] = ()) -> None:
        self.config = config
        self.allowed = tuple(allowed)
        self.subjects = [SweepInput.of_scenario(name, beside) for name in config.scenarios]
        self.subjects += [SweepInput.of_log(name, beside) for name in config.logs]
        self.cases = [case for subject in self.subjects for case in self._cases_of(subject)]

    def __len__(self) -> int:
        return len(self.cases) * len(self.config.seeds)

    def jobs(self) -> Iterator[Job]:
        """Seed by seed, so that a sweep that is stopped half way has tried all cases alike."""
        return (self.job(case, seed) for seed in self.config.seeds for case in self.cases)

    def job(self, case: Case, seed: int) -> Job:
        """One case with one seed. Settings that are drawn are the same in all cases, so that these can be compared."""
        kinds = {key: KINDS[next(iter(text))].model_validate(text) for key, text in self.config.sample.items()}
        drawn = {key: kind.draw(key_rng((key,), self.config.seed, seed)) for key, kind in kinds.items()}
        return Job.of(
            case.subject.digest,
            kind=case.subject.kind,
            name=case.subject.name,
            source=case.subject.source,
            mode=case.mode,
            seed=seed,
            grid=case.grid,
            drawn=drawn,
            settings=(*case.settings, *(setting(*item) for item in drawn.items())),
        )

    def files(self) -> list[Path]:
        """What the runs need besides hopslam itself."""
        return [path for subject in self.subjects for path in subject.files]

    def check(self) -> None:
        """ScenarioError where a setting of a case is wrong; sampled ones are tried at both ends of their range."""
        sampled = [setting(*item) for item in self.config.sample.items()]
        for case in self.cases:
            try:
                checked_template(case.subject.scenario, [*case.settings, *sampled], self.allowed)
            except ScenarioError as error:
                raise InputError(f"{case.label}: {error}") from error

    def _cases_of(self, subject: SweepInput) -> Iterator[Case]:
        common = [setting(*item) for item in self.config.settings.items()]
        for mode in self.config.modes or (subject.mode,):
            for values in product(*self.config.grid.values()):
                grid = dict(zip(self.config.grid, values, strict=True))
                tried = [setting(*item) for item in grid.items()]
                yield Case(subject, mode, grid, (*subject.in_mode(mode), *common, *tried))
