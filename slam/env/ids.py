"""The gymnasium ids of the environments, and the manual of each."""

from collections.abc import Iterator
from inspect import getdoc
from typing import Any, Final

import gymnasium

from slam.errors import InputError, did_you_mean
from slam.named_code import import_by_name

ENV_IDS: Final[dict[str, str | None]] = {
    "hopslam/P3DX-v0": None,
    "hopslam/CampusLoop-v0": "campus_loop",
    "hopslam/ClutteredRoom-v0": "cluttered_room",
    "hopslam/Corridor-v0": "corridor",
    "hopslam/CrowdedCorridor-v0": "crowded_corridor",
    "hopslam/FeaturelessCorridor-v0": "featureless_corridor",
    "hopslam/OfficeLoop-v0": "office_loop",
    "hopslam/PaperCorridor-v0": "paper_corridor",
    "hopslam/PaperSimulation-v0": "paper_simulation",
    "hopslam/RandomOffice-v0": "random_office",
    "hopslam/UmbmarkRoom-v0": "umbmark_room",
}
"""Every id with its scenario; None if the scenario is an argument."""

BATCH: Final = "sim.batch.env:BatchEnv"
"""Entry point, by name: slam does not import sim."""


class _SyncUnlessTold(dict[str, Any]):
    """Arguments that make ``gymnasium.make_vec`` use separate environments by default.

    If the caller gives no ``vectorization_mode``, gymnasium would choose the vector entry point, which has no PyBullet.
    It looks for the mode in these arguments first, by ``pop``.
    """

    def pop(self, key: str, default: Any = None) -> Any:
        return super().pop(key, "sync" if key == "vectorization_mode" and default is None else default)


def register_ids() -> None:
    """Register every id with gymnasium, once.

    ``import sim`` does it, and so does ``gymnasium.make("sim:hopslam/...")``.
    """
    for env_id, scenario in ENV_IDS.items():
        if env_id not in gymnasium.registry:
            kwargs = _SyncUnlessTold({} if scenario is None else {"scenario": scenario})
            gymnasium.register(env_id, "slam.env.p3dx_env:P3DXEnv", vector_entry_point=BATCH, kwargs=kwargs)


def find_env_id(name: str) -> str:
    """Return the whole id of this name, given with or without ``hopslam/``; InputError suggests a similar one."""
    whole = name if name in ENV_IDS else f"hopslam/{name}"
    if whole in ENV_IDS:
        return whole
    hint = did_you_mean(whole, ENV_IDS, otherwise=f"choose one of {', '.join(ENV_IDS)}")
    raise InputError(f"no environment {name!r}; {hint}")


def manual(env_id: str) -> str:
    """Write the manual of the environment with this whole id, as Markdown: its docstring, spaces and clock."""
    register_ids()
    with gymnasium.make(env_id) as made:
        docstring = getdoc(type(made.unwrapped))
        rows = "\n".join(f"| {name} | {value} |" for name, value in _as_built(made.unwrapped))
    batch = getdoc(import_by_name(BATCH))
    return (
        f"# {env_id}\n\n{docstring}\n\n## As built\n\n| | |\n|---|---|\n{rows}\n\n"
        f'## vectorization_mode="vector_entry_point"\n\n{batch}\n'
    )


def _as_built(env: Any) -> Iterator[tuple[str, str]]:
    """Describe spaces and clock of this environment."""
    scenario = env.scenario
    clock, scan_time = scenario.clock, scenario.lidar.description.lidar.scan_time
    yield "action", f"`{env.action_space}`"
    for name, space in env.observation_space.spaces.items():
        yield f"observation {name}", f"`{' '.join(str(space).split())}`"
    yield (
        "time",
        f"a step is a scan, {scan_time:g} s: {clock.controls_per_scan} control steps "
        f"of {clock.steps_per_control} physics steps of 1/{clock.rate} s",
    )
    yield "scenario", f"{scenario.name}: {scenario.description}"
