"""``hopslam bench env``."""


def bench_env() -> None:
    """Measure the learning environments: steps a second of every path, threads, and the memory of a robot.

    The paths are physics, the kinematic model, and batches of it with each view, on one core.

    [bold]Examples[/bold]

    hopslam bench env
    """
    from sim.bench.env_speed import env_tables
    from slam.console.terminal import Terminal

    console = Terminal()
    for table in env_tables(console):
        console.print(table.for_terminal())
