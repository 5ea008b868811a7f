"""``hopslam emulate``."""

from pathlib import Path
from typing import Annotated

import typer

from slam.console.options import Foxglove, FoxgloveAt, RecordWire, Rerun, Ros, ScenarioName, Settings

Share = Annotated[float, typer.Option(min=0.0, max=1.0, metavar="SHARE", help="Share of the bytes, both directions.")]


def emulate(
    scenario: ScenarioName = "corridor",
    link_dir: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Links p3dx and urg04lx, or ld19, are made there.")
    ] = None,
    tcp: Annotated[bool, typer.Option("--tcp", help="TCP ports on the loopback interface instead.")] = False,
    fault: Annotated[
        list[str] | None,
        typer.Option(
            metavar="DEVICE:KIND@AT+SECONDS",
            help="robot or lidar: unplug, stall, e-stop, motors-off, battery-low, battery-empty, dead, reboot.",
        ),
    ] = None,
    bit_errors: Share = 0.0,
    dropped: Share = 0.0,
    duplicated: Share = 0.0,
    drift: Annotated[float, typer.Option(metavar="SHARE", help="Share by which the lidar's clock runs faster.")] = 0.0,
    rs232: Annotated[bool, typer.Option("--rs232", help="The lidar on RS-232: its bit rate limits it.")] = False,
    watchdog: Annotated[float, typer.Option(min=0.0, max=60.0, metavar="S", help="The robot's; 0 is none.")] = 2.0,
    plant: Annotated[str, typer.Option(metavar="NAME", help="Simulation: sim, or plan, without PyBullet.")] = "sim",
    seed: Annotated[int, typer.Option(min=0, help="Seed of the damage to bytes.")] = 0,
    truth: Annotated[Path | None, typer.Option(metavar="FILE", help="Write the true poses there, as TUM text.")] = None,
    record_wire: RecordWire = None,
    settings: Settings = None,
    rerun: Rerun = None,
    ros: Ros = False,
    foxglove: Foxglove = False,
    foxglove_at: FoxgloveAt = None,
) -> None:
    """Emulate a P3-DX and its lidar, a URG-04LX or an LD19, for any software that speaks to such devices.

    The scenario's world moves them in real time. One line of JSON has their addresses once they are ready; they run
    until Ctrl-C.

    [bold]Examples[/bold]

    hopslam emulate corridor --link-dir /tmp/robot

    hopslam emulate crowded_corridor --truth truth.tum --set lidar.noise=realistic --set robot.sonar=true

    hopslam emulate office_loop --link-dir /tmp/robot --rerun serve

    hopslam emulate corridor --plant plan --foxglove

    hopslam emulate corridor --set lidar.model=ld19

    hopslam emulate corridor --tcp --fault lidar:unplug@10+5 --fault robot:e-stop@20+3

    hopslam run corridor --backend hardware --yes --set hardware.robot_port=/tmp/robot/p3dx --set
    hardware.lidar_port=/tmp/robot/urg04lx
    """
    from contextlib import ExitStack

    from hardware.emulator.emulator import emulated_lidar
    from hardware.emulator.serial_line import LineNoise
    from hardware.emulator.serve import EmulatorView, emulator_scene, serve
    from hardware.emulator.topics import EmulatorTopics
    from hardware.wire.session import WireSession
    from slam.console.terminal import Terminal
    from slam.run.backends import make_plant
    from slam.run.topics.topic_choice import TopicChoice
    from slam.run.viewer.viewers import Viewers
    from slam.scenario.file import read_scenario

    noise = LineNoise(bit_errors, dropped, duplicated)
    loaded = read_scenario(scenario, settings or [])
    lidar = emulated_lidar(loaded)
    emulated_plant = make_plant(plant, loaded)
    with ExitStack() as stack:
        wire = stack.enter_context(WireSession(record_wire))
        shows, console = [], Terminal(stderr=True)
        viewers = stack.enter_context(Viewers(rerun or (), console))
        if rerun:
            scene = emulator_scene(loaded)
            broadcast = viewers.open(scene)
            assert broadcast is not None  # somebody watches
            shows.append(EmulatorView(stack.enter_context(broadcast), scene).show)
        choice = TopicChoice(ros, foxglove_at or foxglove)
        if (topics := stack.enter_context(choice.session(console))) is not None:
            shows.append(EmulatorTopics(topics, loaded).show)
        serve(
            emulated_plant, link_dir, tcp, fault or [], noise, drift, rs232, seed, truth, watchdog, shows, wire, lidar
        )
