"""The code and the files that the machines of a cluster need."""

from __future__ import annotations

import shutil
from collections.abc import Iterable
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

import slam
from slam.sweep.bundled_file import SENT

_PACKAGES: Final = ("slam", "sim", "hardware")
_BESIDE: Final = ("assets", "scenarios")
"""Of a checkout; in a wheel they are inside the packages."""


class CodeBundle:
    """A folder of copies: the packages, what lies beside them, and ``files``, each under its whole path."""

    def __init__(self, files: Iterable[Path]) -> None:
        self._temporary = TemporaryDirectory(prefix="hopslam-sweep-")
        self.folder = Path(self._temporary.name)
        root = Path(slam.__file__).resolve().parents[1]
        for name in (*_PACKAGES, *_BESIDE):
            if (root / name).is_dir():
                shutil.copytree(root / name, self.folder / name, ignore=shutil.ignore_patterns("__pycache__"))
        self._name_the_version()
        for file in files:
            place = self.folder / SENT / file.resolve().relative_to("/")
            place.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(file, place)

    def close(self) -> None:
        """Remove the copies."""
        self._temporary.cleanup()

    def _name_the_version(self) -> None:
        """The machines find the version of hopslam here, where it is not installed."""
        number = version("hopslam")
        about = self.folder / f"hopslam-{number}.dist-info"
        about.mkdir()
        (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: hopslam\nVersion: {number}\n")
