"""``hopslam emulate``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from slam.console.options import Foxglove, FoxgloveAt, RecordWire, Rerun, Ros, ScenarioName, Settings

if TYPE_CHECKING:
    from contextlib import ExitStack

    from hardware.emulator.emulator import EmulatorState
    from slam.run.topics.topic_choice import TopicChoice
    from slam.scenario.schema import Scenario

LinkDir = Annotated[
    Path | None, typer.Option(metavar="DIR", help="Folder for the links p3dx and urg04lx, or ld19, to the devices.")
]
Tcp = Annotated[
    bool, typer.Option("--tcp", help="Use TCP ports on the loopback interface instead of pseudo-terminals.")
]
Faults = Annotated[
    list[str] | None,
    typer.Option(
        metavar="DEVICE:KIND@AT+SECONDS",
        help="robot or lidar: unplug, stall, e-stop, motors-off, battery-low, battery-empty, dead, reboot.",
    ),
]
_SHARE: Final[dict[str, Any]] = {"min": 0.0, "max": 1.0, "metavar": "SHARE"}
BitErrors = Annotated[float, typer.Option(**_SHARE, help="Share of bytes with a flipped bit, in both directions.")]
Dropped = Annotated[float, typer.Option(**_SHARE, help="Share of bytes that are lost, in both directions.")]
Duplicated = Annotated[float, typer.Option(**_SHARE, help="Share of bytes that arrive twice, in both directions.")]
Drift = Annotated[float, typer.Option(metavar="SHARE", help="Relative error of the lidar's clock; positive: fast.")]
Rs232 = Annotated[bool, typer.Option("--rs232", help="Connect the lidar by RS-232, with the speed of its bit rate.")]
Watchdog = Annotated[
    float, typer.Option(min=0.0, max=60.0, metavar="S", help="Watchdog of the robot, seconds; 0: none.")
]
PlantName = Annotated[
    str, typer.Option(metavar="NAME", help="Simulation that moves the devices: sim, or plan, without PyBullet.")
]
NoiseSeed = Annotated[int, typer.Option(min=0, help="Seed of the damage to bytes.")]
Truth = Annotated[Path | None, typer.Option(metavar="FILE", help="File for the true poses, as TUM text.")]


def emulate(
    scenario: ScenarioName = "corridor",
    link_dir: LinkDir = None,
    tcp: Tcp = False,
    fault: Faults = None,
    bit_errors: BitErrors = 0.0,
    dropped: Dropped = 0.0,
    duplicated: Duplicated = 0.0,
    drift: Drift = 0.0,
    rs232: Rs232 = False,
    watchdog: Watchdog = 2.0,
    plant: PlantName = "sim",
    seed: NoiseSeed = 0,
    truth: Truth = None,
    record_wire: RecordWire = None,
    settings: Settings = None,
    rerun: Rerun = None,
    ros: Ros = False,
    foxglove: Foxglove = False,
    foxglove_at: FoxgloveAt = None,
) -> None:
    """Emulate a P3-DX and its lidar, a URG-04LX or an LD19, for any software that speaks to such devices.

    They move in the scenario's world in real time. Once they are ready, one line of JSON with their addresses is
    printed; they run until Ctrl-C.

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
    from hardware.emulator.serve import serve
    from hardware.wire.session import WireSession
    from slam.run.backends import make_plant
    from slam.run.topics.topic_choice import TopicChoice
    from slam.scenario.file import read_scenario

    noise = LineNoise(bit_errors, dropped, duplicated)
    loaded = read_scenario(scenario, settings or [])
    lidar = emulated_lidar(loaded)
    emulated_plant = make_plant(plant, loaded)
    with ExitStack() as stack:
        wire = stack.enter_context(WireSession(record_wire))
        shows = _open_shows(stack, loaded, rerun or (), TopicChoice(ros, foxglove_at or foxglove))
        serve(
            emulated_plant, link_dir, tcp, fault or [], noise, drift, rs232, seed, truth, watchdog, shows, wire, lidar
        )


def _open_shows(
    stack: ExitStack, scenario: Scenario, rerun: Sequence[str], topics: TopicChoice
) -> list[Callable[[EmulatorState], None]]:
    """Open the viewers and the topics; return the functions that show a state there."""
    from hardware.emulator.serve import EmulatorView, emulator_scene
    from hardware.emulator.topics import EmulatorTopics
    from slam.console.terminal import Terminal
    from slam.run.viewer.viewers import Viewers

    shows: list[Callable[[EmulatorState], None]] = []
    console = Terminal(stderr=True)
    viewers = stack.enter_context(Viewers(rerun, console))
    if rerun:
        scene = emulator_scene(scenario)
        broadcast = viewers.open(scene)
        assert broadcast is not None  # there is a target
        shows.append(EmulatorView(stack.enter_context(broadcast), scene).show)
    if (session := stack.enter_context(topics.session(console))) is not None:
        shows.append(EmulatorTopics(session, scenario).show)
    return shows
