"""``hopslam bench env``."""


def bench_env() -> None:
    """Measure the learning environments: steps a second on one core with physics, with the kinematic model, and of
    batches of it with each view; threads, and the memory of a robot.

    [bold]Examples[/bold]

    hopslam bench env
    """
    from sim.bench.env_speed import env_tables
    from slam.console.terminal import Terminal

    console = Terminal()
    for table in env_tables(console):
        console.print(table.for_terminal())
