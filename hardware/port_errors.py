"""Reasons why a port cannot be opened or was lost, each with the next step for the user."""

import errno
import os
import re
import socket
import stat
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Final
from urllib.parse import urlsplit

_NOT_A_PORT: Final = "this is not a serial port; hopslam doctor without a name lists the serial ports"
_SILENT_HOST: Final = "the host does not answer; is it switched on, and in this network?"
_REASONS: Final = {
    errno.ENOENT: "there is no such port; plug the device in, and hopslam doctor lists the ports",
    errno.EBUSY: "another program is using it; close that one first",
    errno.EAGAIN: "another program is using it; close that one first",
    errno.EIO: "the device is gone; was it unplugged?",
    errno.ENXIO: "the device is gone; was it unplugged?",
    errno.ENODEV: "the device is gone; was it unplugged?",
    errno.ENOTTY: _NOT_A_PORT,
    errno.EISDIR: _NOT_A_PORT,
    errno.ECONNREFUSED: "nobody listens there; start the emulator or the serial server first, or correct the number",
    errno.ECONNRESET: "the other side has hung up; is another program using it?",
    errno.EPIPE: "the other side has hung up; is another program using it?",
    errno.ETIMEDOUT: _SILENT_HOST,
    errno.EHOSTUNREACH: _SILENT_HOST,
    errno.ENETUNREACH: "that network cannot be reached; is this computer connected?",
}
_IN_WORDS: Final = re.compile(r"Error\((\d+),")
"""Number of a cause that pyserial gives only as text on Windows, such as ``PermissionError(13, ...)``."""
_URL_FORM: Final = "a port over the network is {scheme}://HOST:NUMBER, such as {scheme}://192.168.1.7:4001"


def reason_of(url: str, error: BaseException) -> str:
    """Return why this port failed, and what to do about it; pyserial hides the cause inside its own exceptions."""
    parts = urlsplit(url)
    if parts.scheme in ("socket", "rfc2217") and not _has_host_and_number(url):
        return _URL_FORM.format(scheme=parts.scheme)
    causes = list(_causes(error))
    if any(isinstance(cause, socket.gaierror) for cause in causes):
        return f"no host is called {parts.hostname}; correct the name, or give its address"
    if any(isinstance(cause, TimeoutError) for cause in causes):
        return _SILENT_HOST
    number = next(filter(None, map(_number, causes)), None)
    if number is None and "Could not exclusively lock" in str(error):
        number = errno.EBUSY
    if sys.platform == "win32" and number is None:
        number = _number_in_words(str(error))
    if number in (errno.EACCES, errno.EPERM):
        return _not_permitted(Path(url))
    return _REASONS.get(number or 0, str(error))


def _has_host_and_number(url: str) -> bool:
    try:
        parts = urlsplit(url)
        return bool(parts.hostname) and bool(parts.port)
    except ValueError:  # not a number, or too large
        return False


def _causes(error: BaseException | None) -> Iterator[BaseException]:
    while error is not None:
        yield error
        error = error.__cause__ or error.__context__


def _number(error: BaseException) -> int | None:
    """Return the number of an error of the operating system; termios has an exception class of its own."""
    number = getattr(error, "errno", None) or (error.args[0] if error.args else None)
    return number if isinstance(number, int) and number > 0 else None


def _number_in_words(words: str) -> int | None:
    """Return the error number in a message of pyserial. A port that fails after it was open counts as unplugged."""
    found = _IN_WORDS.search(words)
    if found is None or "Cannot configure port" in words:
        return None
    return int(found[1]) if words.startswith("could not open port") else errno.EIO


def _not_permitted(path: Path) -> str:
    """Return the reason why this program may not open a port, with advice; on Windows another program uses it."""
    if sys.platform == "win32":
        return _REASONS[errno.EBUSY]
    import grp

    try:
        status = os.stat(path)  # noqa: PTH116
        group = grp.getgrgid(status.st_gid).gr_name
    except (OSError, KeyError):
        group = "dialout"
    else:
        if not stat.S_ISCHR(status.st_mode):
            return _NOT_A_PORT
        if group == "root":
            return "only root may use this port; a udev rule can give it to the group dialout: see docs/hardware.md"
    return f"you may not use this port; run: sudo usermod -aG {group} $USER, then log out and in again"
