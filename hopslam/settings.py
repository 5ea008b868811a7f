"""Settings of the method in the forms that a caller may pass."""

from collections.abc import Sequence

from slam.config import SlamConfig
from slam.errors import ScenarioError, shown
from slam.scenario.file import load_scenario
from slam.scenario.settings import one_or_several

SettingsLike = str | Sequence[str] | SlamConfig


def slam_config(settings: SettingsLike) -> SlamConfig:
    """Return a SlamConfig as it is, or the defaults changed by ``slam.key=value``.

    ScenarioError for a wrong setting.
    """
    if isinstance(settings, SlamConfig):
        return settings
    if not isinstance(settings, str | Sequence):
        raise ScenarioError(f"settings are of type {type(settings).__name__}; give slam.key=value, or a SlamConfig")
    given = one_or_several(settings)
    for setting in given:
        if not isinstance(setting, str) or not setting.strip().startswith("slam."):
            raise ScenarioError(
                f"settings: {shown(setting)} is not a setting of the method; "
                "write slam.key=value, as in slam.mode=paper"
            )
    try:
        return load_scenario("replay", given).slam
    except ScenarioError as error:
        fault = str(error).removeprefix("--set").lstrip(": ")
        raise ScenarioError(f"settings: {fault.replace('--set ', '')}") from error
