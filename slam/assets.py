"""Files that describe the robot."""

from pathlib import Path
from typing import Final

from slam.errors import RobotError

P3DX_URDF: Final = "urdf/p3dx.urdf"
_ROOT: Final = Path(__file__).resolve().parents[1]
_FOLDERS: Final = _ROOT / "sim" / "assets", _ROOT / "assets"
"""Folders of ``assets/``: in the installed wheel, or at the root of a checkout."""


def asset(name: str) -> Path:
    """Find a file under ``assets/``, for example ``urdf/p3dx.urdf``; RobotError says where it was looked for."""
    for folder in _FOLDERS:
        if (folder / name).is_file():
            return folder / name
    places = " or ".join(str(folder) for folder in _FOLDERS)
    raise RobotError(f"no asset {name!r} in {places}; install hopslam again, or run it from a whole checkout")
