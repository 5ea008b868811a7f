"""The code, files and package versions that the machines of a cluster need for the runs of a sweep."""

import platform
import shutil
from collections.abc import Iterable
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

import slam

_CODE: Final = ("slam", "sim", "hardware", "assets", "scenarios")
"""Folders of a checkout; in a wheel the last two are inside the packages."""
_FILES: Final = Path("sent")
"""Folder beside the packages in which each file has its path on the driver's machine."""
_COMPUTING_PACKAGES: Final = ("hopslam", "numba", "numpy", "pybullet", "scipy")


class CodeBundle:
    """Temporary folder with copies of the code and of ``files``, each with its full path."""

    def __init__(self, files: Iterable[Path]) -> None:
        self._temporary = TemporaryDirectory(prefix="hopslam-sweep-")
        self.folder = Path(self._temporary.name)
        root = Path(slam.__file__).resolve().parents[1]
        for name in _CODE:
            if (root / name).is_dir():
                shutil.copytree(root / name, self.folder / name, ignore=shutil.ignore_patterns("__pycache__"))
        number = version("hopslam")  # hopslam is not installed on the machines: this gives them its version
        about = self.folder / f"hopslam-{number}.dist-info"
        about.mkdir()
        (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: hopslam\nVersion: {number}\n", encoding="utf-8")
        for file in files:
            place = self.folder / _FILES / file.resolve().relative_to("/")
            place.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(file, place)

    def close(self) -> None:
        """Remove the copies."""
        self._temporary.cleanup()


def bundled_path(source: str) -> str:
    """Return the path of a scenario or log on this machine: in the received bundle, else ``source`` itself."""
    path = Path(source)
    if not path.is_absolute():
        return source
    sent = Path(__file__).parents[2] / _FILES / path.relative_to("/")
    return str(sent) if sent.is_file() else source


@cache
def versions() -> dict[str, str]:
    """Return the versions of Python and of the packages that compute, by name; ``none`` for a missing one."""
    return {"python": platform.python_version()} | {name: _version(name) for name in _COMPUTING_PACKAGES}


def version_difference(here: dict[str, str], there: dict[str, str]) -> str:
    """Describe the versions that differ; empty if none does."""
    differing = (name for name in here if there.get(name) != here[name])
    return ", ".join(f"{name} {there.get(name)} instead of {here[name]}" for name in differing)


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "none"
