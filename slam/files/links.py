"""Links to folders and files, where the system supports them."""

import os
import stat
import sys
from contextlib import suppress
from pathlib import Path


def is_folder_link(path: Path) -> bool:
    """Return True for a symbolic link and, on Windows, for a junction."""
    if sys.platform == "win32" and os.path.lexists(path):
        return path.is_symlink() or path.lstat().st_reparse_tag == stat.IO_REPARSE_TAG_MOUNT_POINT
    return path.is_symlink()


def link_folder(link: Path, folder: Path) -> None:
    """Make a link to a folder beside it, and replace the link that was there.

    On Windows it is a junction, because few users may make symbolic links there. On a file system without links, as on
    most USB sticks, no link is made.
    """
    if sys.platform == "win32":
        import _winapi

        link.unlink(missing_ok=True)
        with suppress(OSError):
            _winapi.CreateJunction(str(folder.absolute()), str(link))
        return
    draft = link.with_name(f".{link.name}-{os.getpid()}")
    draft.unlink(missing_ok=True)
    with suppress(PermissionError):
        draft.symlink_to(folder.name)
        draft.replace(link)


def link_file(file: Path, place: Path) -> None:
    """Make a file readable at a second place on the same disk, without a copy."""
    try:
        place.symlink_to(file.resolve())
    except OSError:  # on Windows, for most users
        os.link(file.resolve(), place)


def is_linked_file(place: Path) -> bool:
    """Return True for a file placed here by ``link_file``."""
    return place.is_symlink() or place.stat().st_nlink > 1
