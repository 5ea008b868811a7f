"""A policy drives: in the simulator, or the real robot, or devices that are emulated.

    hopslam emulate random_office --link-dir /tmp/robot     # in another terminal, where there is no robot
    python docs/examples/drive.py runs/train/policy.zip --backend hardware --set hardware.robot_port=/tmp/robot/p3dx \
        --set hardware.lidar_port=/tmp/robot/urg04lx

`by-hand` instead of the file is a policy without training, which needs no other packages.
"""

import sys
from pathlib import Path
from typing import Annotated, Any

import typer
from explorer import ByHand, explorer

from slam.errors import HopslamError, InputError


def load(policy: str) -> Any:
    """The policy of this file, or the one written by hand. Loading runs code that the file holds."""
    if policy == "by-hand":
        return ByHand()
    if not any(Path(path).is_file() for path in (policy, f"{policy}.zip")):
        raise InputError(f"no policy {policy}; train.py writes one, and by-hand needs none")
    try:
        from stable_baselines3 import PPO
    except ImportError as error:
        raise InputError("a trained policy needs stable-baselines3: pip install 'hopslam[rl]'") from error
    try:
        return PPO.load(policy, device="cpu")
    except Exception as error:
        raise InputError(f"{policy} is not a policy that PPO loads: {str(error).partition(chr(10))[0]}") from error


def drive(
    policy: Annotated[str, typer.Argument(help="policy.zip of train.py, or by-hand.")] = "runs/train/policy.zip",
    backend: Annotated[str, typer.Option(help="sim; hardware; or module:Class, a robot of your own.")] = "sim",
    settings: Annotated[list[str] | None, typer.Option("--set", metavar="KEY=VALUE")] = None,
    yes: Annotated[bool, typer.Option("--yes", help="The real robot moves without asking first.")] = False,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="The real robot never moves.")] = False,
    seed: Annotated[int, typer.Option(help="Seed of the simulated office.")] = 0,
) -> None:
    """Drive one episode, and print its result."""
    try:
        model = load(policy)
        with explorer(settings or [], backend=backend, yes=yes, dry_run=dry_run) as env:
            (seen, info), over, earned = env.reset(seed=seed), False, 0.0
            while not over:
                action, _ = model.predict(seen, deterministic=True)
                seen, reward, terminated, truncated, info = env.step(action)
                earned, over = earned + reward, terminated or truncated
    except HopslamError as error:
        print(error, file=sys.stderr)
        raise SystemExit(error.exit_code) from error
    x, y, theta = info["pose"]
    print(f"{info['ending']} after {info['seconds']:.1f} s, {earned:.1f} m^2; at {x:.2f}, {y:.2f} m, {theta:.2f} rad")
    print(f"the pose is {'the truth' if info['pose_from'] == 'truth' else 'where SLAM believes the robot is'}")


if __name__ == "__main__":
    typer.run(drive)
