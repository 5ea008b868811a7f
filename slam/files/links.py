"""Links: to the folder of the last run, and to files that are read at two places."""

import os
import stat
import sys
from contextlib import suppress
from pathlib import Path


def is_folder_link(path: Path) -> bool:
    """Tell if a path is what ``link_folder`` makes: a symbolic link, or on Windows a junction."""
    if sys.platform == "win32" and os.path.lexists(path):
        return path.is_symlink() or path.lstat().st_reparse_tag == stat.IO_REPARSE_TAG_MOUNT_POINT
    return path.is_symlink()


def link_folder(link: Path, folder: Path) -> None:
    """Let a link lead to a folder beside it, in the place of the link that was there.

    Windows lets few users make symbolic links, and all users make junctions. Where the file system has no links, such
    as that of most USB sticks, there is none.
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


def lend_file(file: Path, place: Path) -> None:
    """Let a file be read at another place of the same disk, too."""
    try:
        place.symlink_to(file.resolve())
    except OSError:  # on Windows, for most users
        os.link(file.resolve(), place)


def is_lent(place: Path) -> bool:
    """Tell a file that was lent to this place from one that was written there."""
    return place.is_symlink() or place.stat().st_nlink > 1
