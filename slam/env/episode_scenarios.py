"""The scenarios of the episodes of an environment."""

from collections.abc import Sequence
from pathlib import Path

from slam.env.config import EnvConfig
from slam.env.reset_options import ResetOptions
from slam.errors import ScenarioError
from slam.scenario.file import load_template
from slam.scenario.schema import Scenario
from slam.scenario.settings import one_or_several
from slam.scenario.template import ScenarioTemplate


class EpisodeScenarios:
    """Draws scenarios from a file, given by name or path with settings on top; a scenario as a value stays as it is."""

    def __init__(
        self,
        scenario: str | Path | Scenario,
        settings: str | Sequence[str],
        allow_modules: str | Sequence[str],
        config: EnvConfig,
    ) -> None:
        self._config = config
        self._given, self._settings = scenario, one_or_several(settings)
        self._allow_modules = one_or_several(allow_modules)
        self._template: ScenarioTemplate | None = None
        if isinstance(scenario, Scenario) and not self._settings:
            self.first = scenario
            """The scenario of the file's own seed."""
        else:
            self._template = self._load()
            self.first = self._template.draw()
        config.require_route(self.first)

    def draw(self, seed: int | None, options: ResetOptions) -> Scenario:
        """Make the scenario of an episode with this seed, or the file's own; ``first`` itself where it is that one."""
        if options.settings:
            scenario = self._load(options.settings).draw(seed)
        elif self._template is None or not self._template.random:
            scenario = self.first
        else:
            scenario = self._template.draw(seed)
        scenario = options.applied(scenario)
        if scenario.lidar.description != self.first.lidar.description:
            raise ScenarioError(f"{scenario.name}: lidar.model cannot change, nor be random: spaces stay as they are")
        self._config.require_route(scenario)
        return scenario

    def _load(self, more: tuple[str, ...] = ()) -> ScenarioTemplate:
        """Load the file, with more settings on top; ScenarioError for a value, which takes none."""
        settings = self._settings + more
        if isinstance(self._given, Scenario):
            raise ScenarioError(
                f"settings={list(settings)}: the scenario is a value here; change it, or give its name or file instead"
            )
        return load_template(self._given, settings, self._allow_modules)
