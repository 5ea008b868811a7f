"""The scenarios of the episodes of an environment."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from slam.errors import ScenarioError
from slam.run.env.reset_options import ResetOptions
from slam.run.scenario.file import load_template
from slam.run.scenario.schema import Scenario
from slam.run.scenario.template import ScenarioTemplate
from slam.run.texts import texts


class Worlds:
    """Drawn from one scenario: a name or a path with settings on top, or a value."""

    def __init__(
        self,
        scenario: str | Path | Scenario,
        settings: str | Sequence[str] = (),
        allow_modules: str | Sequence[str] = (),
    ) -> None:
        self._given, self._settings, self._allow_modules = scenario, texts(settings), texts(allow_modules)
        self._template = self._load(())
        self.first = scenario if isinstance(scenario, Scenario) else self._read(scenario, ()).draw()
        """The scenario of the file's own seed."""

    def draw(self, seed: int | None, options: ResetOptions) -> Scenario:
        """The scenario of the episode of this seed, or of the file's own; ``first`` itself where it is that one."""
        template = self._load(options.settings) if options.settings else self._template
        same = template is None or (template is self._template and (seed is None or not template.random))
        return options.applied(self.first if same or template is None else template.draw(seed))

    def _load(self, more: tuple[str, ...]) -> ScenarioTemplate | None:
        """What to draw from, with more settings on top; None for a value, which takes none."""
        settings = self._settings + more
        if not isinstance(self._given, Scenario):
            return self._read(self._given, more)
        if settings:
            raise ScenarioError(
                f"settings={list(settings)}: the scenario is a value here; change it, or give its name or file instead"
            )
        return None

    def _read(self, name: str | Path, more: tuple[str, ...]) -> ScenarioTemplate:
        return load_template(name, self._settings + more, self._allow_modules)
