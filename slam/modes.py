"""The modes: the default method of each part of the SLAM."""

from collections.abc import Mapping
from typing import Final, Literal, NamedTuple

ModeName = Literal["hopslam", "paper", "dead_reckoning"]


class Mode(NamedTuple):
    """The methods of the three parts, and the other settings that the mode changes."""

    lines: str
    map: str
    matching: str
    settings: Mapping[str, bool | str] = {}


MODES: Final[dict[ModeName, Mode]] = {
    "hopslam": Mode("chi_square", "surfels", "least_squares"),
    "paper": Mode("paper", "points", "force_field", {"deskew": False, "loops": "never"}),
    "dead_reckoning": Mode("chi_square", "surfels", "least_squares"),  # no part of it runs
}
"""Modes in the order of reports; the first is the default."""


def mode_with(part: str, method: str) -> ModeName | None:
    """Return the first mode whose ``lines``, ``map`` or ``matching`` has this method; None for any other part."""
    return next((name for name, mode in MODES.items() if mode._asdict().get(part) == method), None)
