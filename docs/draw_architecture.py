"""Draw the pictures of docs/architecture.md from the code: ``python docs/draw_architecture.py``, or ``make pictures``.

The layers are those of the contracts in pyproject.toml. A way is a list of functions; a box has the function's name and
the first line of its docstring, and tests/test_architecture.py sees that a run calls them in this order.
"""

import tomllib
from html import escape
from importlib import import_module
from inspect import getdoc
from pathlib import Path
from textwrap import wrap
from typing import Any, Final

HERE: Final = Path(__file__).parent
WAYS: Final = {
    "scan": (
        "sim.robot:SimRobot.observe",
        "sim.lidar:SimulatedLidar.scan",
        "sim.lidar_noise:measure",
        "slam.line_slam:LineSlam.update",
        "slam.deskew:deskewed",
        "slam.lines.extraction:extract_segments",
        "slam.matching.surfel_mapper:SurfelMapper.locate",
        "slam.lines.facets:facets_of",
        "slam.mapping.surfel_map:SurfelMap.write",
        "slam.graph.loop_closing:LoopClosing.follow",
        "slam.run.pilots:WaypointPilot.command",
        "slam.files.ros.encoder:Encoder.scan",
    ),
    "key": (
        "slam.scenario.file:load_scenario",
        "slam.scenario.source:ScenarioSource",
        "slam.scenario.settings:apply_settings",
        "slam.scenario.template:ScenarioTemplate",
        "slam.scenario.values:Within.check",
        "slam.scenario.checks:find_obstruction",
        "slam.scenario.template:ScenarioTemplate.draw",
        "sim.robot:SimRobot",
        "sim.controller:Controller",
        "sim.records:model_of",
        "sim.controller:Controller.read_wheels",
    ),
    "byte": (
        "hardware.serial_port:SerialPort.read",
        "hardware.scip.frames:FrameDecoder.feed",
        "hardware.scip.partial_scans:partial_scans",
        "hardware.scip.encoding:decode_values",
        "hardware.scip.scan_data:to_metres",
        "hardware.sensor_clock:SensorClock.host_time",
        "hardware.scan_queue:ScanQueue.put",
        "hardware.robot:HardwareRobot.observe",
        "hardware.scan_queue:ScanQueue.take",
        "hardware.devices:RobotDevices.observation",
    ),
}
"""Stations of a simulated scan from the world to the log, of ``robot.odometry.travel_noise`` from the file to the
wheels, and of a byte of the lidar from the port to an observation."""
TITLES: Final = {"scan": "A scan", "key": "A key of a scenario", "byte": "A byte of the lidar"}
COLOURS: Final = {"hopslam": "#d9cde8", "sim": "#cfe3f2", "slam": "#f4f4f4", "hardware": "#fbe0cf"}
STYLE: Final = "<style>text{font:12px sans-serif;fill:#222}.b{font-weight:bold}.c{font:11px monospace}</style>"


def station(name: str) -> Any:
    """Return the class or function at ``module:name``."""
    module, _, path = name.partition(":")
    found: Any = import_module(module)
    for part in path.split("."):
        found = getattr(found, part)
    return found


def picture(width: float, height: float, parts: list[str]) -> str:
    """Return the text of an SVG file."""
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}">'
    marker = '<marker id="a" viewBox="0 0 6 6" refX="6" refY="3" markerWidth="6" markerHeight="6" orient="auto">'
    ground = f'<rect width="{width:g}" height="{height:g}" fill="white"/>'
    arrow = f'<defs>{marker}<path d="M0 0L6 3L0 6z" fill="#555"/></marker></defs>'
    return "\n".join([head, STYLE, arrow, ground, *parts, "</svg>\n"])


def box(x: float, y: float, width: float, colour: str, lines: list[tuple[str, str]]) -> tuple[list[str], float]:
    """Draw a box with lines of (class, text), 15 units each; return it and its height."""
    height = 15.0 * len(lines) + 8.0
    rect = f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" rx="3" fill="{colour}" stroke="#999"/>'
    texts = [
        f'<text class="{kind}" x="{x + 6:g}" y="{y + 15 * (row + 1):g}">{escape(text)}</text>'
        for row, (kind, text) in enumerate(lines)
    ]
    return [rect, *texts], height


def arrow(x: float, y: float, length: float) -> str:
    """Draw an arrow down."""
    return f'<path d="M{x:g} {y:g}v{length - 1:g}" stroke="#555" marker-end="url(#a)"/>'


def layers_of(package: str) -> list[str]:
    """Return the layers of a package by its import contract, the top one first."""
    contracts = tomllib.loads((HERE.parent / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    return next(contract["layers"] for contract in contracts if contract.get("containers") == [package])


def layer_picture() -> str:
    """Draw the four packages, each a column of its layers; a layer imports from those below it."""
    width, parts, bottom = 272.0, [], 0.0
    head, height = box(
        8, 8, 3 * width + 32, COLOURS["hopslam"], [("b", "hopslam"), ("c", " > ".join(layers_of("hopslam")))]
    )
    parts += head
    for column, package in enumerate(("sim", "slam", "hardware")):
        x, y = 8 + column * (width + 16), 8 + height + 10
        for row, layer in enumerate([package, *layers_of(package)]):
            words = layer.translate(str.maketrans("()", "  ")).split(" | ")
            lines = [("b" if row == 0 else "c", text) for text in wrap("  ".join(map(str.strip, words)), 39)]
            drawn, tall = box(x, y, width, COLOURS[package] if row else "white", lines)
            parts += drawn
            y += tall + 4
        bottom = max(bottom, y)
    return picture(3 * width + 48, bottom + 4, parts)


def way_picture() -> str:
    """Draw the ways beside each other, each a column of stations."""
    width, parts, bottom = 330.0, [], 0.0
    for column, (way, stations) in enumerate(WAYS.items()):
        x, y = 8 + column * (width + 16), 36.0
        parts.append(f'<text class="b" x="{x:g}" y="22">{TITLES[way]}</text>')
        for row, name in enumerate(stations):
            module, _, function = name.partition(":")
            first = (getdoc(station(name)) or "").splitlines()[0].replace("``", "")
            lines = [("b", function), ("c", module), *(("", text) for text in wrap(first, 54))]
            if row:
                parts.append(arrow(x + width / 2, y - 14, 14))
            drawn, tall = box(x, y, width, COLOURS[module.partition(".")[0]], lines)
            parts += drawn
            y += tall + 14
        bottom = max(bottom, y)
    return picture(3 * width + 48, bottom - 6, parts)


PICTURES: Final = {"architecture-layers.svg": layer_picture, "architecture-ways.svg": way_picture}
"""Function that draws each file in docs/."""

if __name__ == "__main__":
    for file, draw in PICTURES.items():
        (HERE / file).write_text(draw())
