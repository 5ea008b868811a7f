"""A policy drives: in the simulator, or the real robot, or devices that are emulated.

    hopslam emulate random_office --link-dir /tmp/bench     # in another terminal, where there is no robot
    python docs/examples/drive.py runs/train/policy.zip --backend hardware --set hardware.robot_port=/tmp/bench/p3dx \
        --set hardware.lidar_port=/tmp/bench/urg04lx

`by-hand` in the place of the file is a policy that nobody had to train, and needs nothing installed.
"""

from typing import Annotated, Any

import typer
from explorer import ByHand, explorer

from slam.errors import HopslamError


def load(policy: str) -> Any:
    """The policy of this file, or the one written by hand."""
    if policy == "by-hand":
        return ByHand()
    from stable_baselines3 import PPO

    return PPO.load(policy, device="cpu")


def drive(
    policy: Annotated[str, typer.Argument(help="policy.zip of train.py, or by-hand.")] = "runs/train/policy.zip",
    backend: Annotated[str, typer.Option(help="sim; hardware; or module:Class, a robot of your own.")] = "sim",
    settings: Annotated[list[str] | None, typer.Option("--set", metavar="KEY=VALUE")] = None,
    yes: Annotated[bool, typer.Option("--yes", help="The real robot moves without asking first.")] = False,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="The real robot never moves.")] = False,
    seed: Annotated[int, typer.Option(help="Of the simulated office.")] = 0,
) -> None:
    """One episode, with what it came to."""
    model = load(policy)
    try:
        with explorer(settings or [], backend=backend, yes=yes, dry_run=dry_run) as env:
            (seen, info), over, earned = env.reset(seed=seed), False, 0.0
            while not over:
                action, _ = model.predict(seen, deterministic=True)
                seen, reward, terminated, truncated, info = env.step(action)
                earned, over = earned + reward, terminated or truncated
    except HopslamError as error:
        raise SystemExit(str(error)) from error
    x, y, theta = info["pose"]
    print(f"{info['ending']} after {info['seconds']:.1f} s, {earned:.1f} m^2; at {x:.2f}, {y:.2f} m, {theta:.2f} rad")
    print(f"the pose is {'the truth' if info['pose_from'] == 'truth' else 'where SLAM believes the robot is'}")


if __name__ == "__main__":
    typer.run(drive)
