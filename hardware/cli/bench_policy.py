"""``hopslam bench policy``."""

from typing import Annotated

import typer


def bench_policy(
    policy: Annotated[str, typer.Argument(help="Policy: goal, or module:Class; see docs/env.md.")] = "goal",
    episodes: Annotated[int, typer.Option(min=1, help="Episodes in every simulator.")] = 20,
    devices: Annotated[int, typer.Option(min=0, help="Episodes on emulated devices, in real time.")] = 1,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the first episode; the others follow.")] = 0,
) -> None:
    """Score the same policy in a batch, in the kinematic simulator, in PyBullet, and on emulated devices.

    goal drives to the next way-point of the corridor for 20 s. Your own class loads a trained policy: its attributes
    env_id and arguments define the environment, and calling it with an observation returns an action.

    [bold]Examples[/bold]

    hopslam bench policy

    hopslam bench policy learnt:Learnt --episodes 40 --devices 2
    """
    import os

    from slam.console.terminal import Terminal

    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from hardware.bench.policy_report import policy_table

    console = Terminal()
    seeds = range(seed, seed + episodes)
    console.print(policy_table(policy, seeds, min(devices, episodes), console).for_terminal())
