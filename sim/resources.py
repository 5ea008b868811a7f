"""Where the files under ``assets/`` are: in the installed wheel, or at the root of a checkout."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from slam.errors import RobotError

PACKAGE: Final = Path(__file__).resolve().parent
FOLDERS: Final = (PACKAGE / "assets", PACKAGE.parent / "assets")


def asset(name: str) -> Path:
    """The file of this name, for example ``urdf/p3dx.urdf``; RobotError says where it was looked for."""
    for folder in FOLDERS:
        if (folder / name).is_file():
            return folder / name
    places = " or ".join(str(folder) for folder in FOLDERS)
    raise RobotError(f"no asset {name!r} in {places}; install hopslam again, or run it from a whole checkout")
