"""Replaces files in the folder of a run, all together or not at all."""

import shutil
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import mkdtemp
from typing import Final

from slam.files.atomic_files import DRAFT, clear_drafts
from slam.files.disk import disk
from slam.files.links import is_linked_file

READY: Final = ".ready"
"""Folder of new files that are all complete, and not all in place yet."""


@contextmanager
def folder_update(folder: Path, outdated: Iterable[str] = ()) -> Iterator[Path]:
    """Make a folder for new files of a run.

    If the block ends without an error, one rename makes them valid; then each is put in place, and the ``outdated``
    ones are removed. If the process is killed after that rename, ``finish_update`` does the rest. Links made by
    ``link_file`` (symbolic or hard links) are not moved into the folder.
    """
    finish_update(folder)
    clear_drafts(folder)
    draft = Path(mkdtemp(prefix=DRAFT, dir=folder))
    try:
        new = draft / "run"
        yield new
        for path in new.iterdir():
            if is_linked_file(path):
                path.unlink()
        for name in outdated:
            (new / name).touch()
        disk().rename(new, folder / READY)
    finally:
        shutil.rmtree(draft, ignore_errors=True)
    finish_update(folder)


def finish_update(folder: Path) -> None:
    """Put new complete files in place; an empty one stands for a file to remove.

    Two processes may do it at the same time. OSError if the folder cannot be changed.
    """
    ready = folder / READY
    if not ready.is_dir():
        return
    for path in sorted(ready.iterdir()):
        with suppress(FileNotFoundError):  # another process was faster
            if path.stat().st_size:
                disk().rename(path, folder / path.name)
            else:
                (folder / path.name).unlink(missing_ok=True)
                path.unlink()
    with suppress(FileNotFoundError):
        ready.rmdir()
