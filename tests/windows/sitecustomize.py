"""Windows, as far as hopslam can tell, on a system of another kind: Python imports this at its start by PYTHONPATH.

The modules that hopslam imports lack what Windows does not have; other packages see the real system. In the whole
process symbolic links cannot be made, open files cannot be renamed or removed, and text is cp1252 with CR LF.
"""

import builtins
import errno
import fcntl
import io
import locale
import os
import select
import shutil
import signal
import socket
import sys
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path
from types import ModuleType
from typing import Any

OWN = {"hopslam", "slam", "sim", "hardware"}
ABSENT = {"fcntl", "grp", "pty", "pwd", "resource", "termios", "tty"}
NOT_IN_OS = {
    "fork", "getegid", "geteuid", "getgid", "getloadavg", "getpgid", "getuid", "killpg", "mkfifo", "nice", "openpty",
    "pread", "pwrite", "register_at_fork", "sched_getaffinity", "set_blocking", "setpgid", "setsid", "sysconf",
    "ttyname", "uname", "wait",
}  # fmt: skip
SIGNALS = {"SIGABRT", "SIGFPE", "SIGILL", "SIGINT", "SIGSEGV", "SIGTERM", "SIG_DFL", "SIG_IGN"}
DENIED, INVALID = (errno.EACCES, "Access is denied"), (errno.EINVAL, "A required privilege is not held by the client")


class View(ModuleType):
    """A module without some of its names, and with others."""

    def __init__(self, module: ModuleType, missing: Iterable[str] = (), **added: Any) -> None:
        super().__init__(module.__name__)
        vars(self).update(_module=module, _missing=set(missing), **added)

    def __getattr__(self, name: str) -> Any:
        if name in vars(self)["_missing"]:
            raise AttributeError(f"module {self.__name__!r} has no attribute {name!r} on Windows")
        return getattr(vars(self)["_module"], name)

    def __setattr__(self, name: str, value: object) -> None:
        setattr(vars(self)["_module"], name, value)


def made(name: str, **content: Any) -> ModuleType:
    """A module that only Windows has."""
    module = ModuleType(name)
    vars(module).update(content)
    return module


def select_sockets(reads: Any, writes: Any, errors: Any, timeout: float | None = None) -> Any:
    for end in (*reads, *writes, *errors):
        socket.socket(
            fileno=os.dup(end if isinstance(end, int) else end.fileno())
        ).close()  # OSError if it is no socket
    return select.select(reads, writes, errors, timeout)


def kill(process: int, number: int) -> None:
    assert number != 0, "that is Ctrl-C for everybody"
    os.kill(process, number)


def create_junction(target: str, link: str) -> None:
    assert Path(target).is_absolute()
    assert Path(target).is_dir()
    symlink(target, link)


def lock(file: int, _mode: int, _count: int) -> None:
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise OSError(*DENIED) from None


VIEWS = {
    "os": View(os, NOT_IN_OS, name="nt", linesep="\r\n", kill=kill),
    "select": View(select, {"poll", "epoll"}, select=select_sockets),
    "signal": View(
        signal, {n for n in dir(signal) if n.startswith("SIG") and n not in SIGNALS}, SIGBREAK=signal.SIGUSR2
    ),
    "sys": View(sys, platform="win32"),
    "msvcrt": made("msvcrt", locking=lock, LK_NBLCK=2, kbhit=lambda: False),
    "_winapi": made("_winapi", CreateJunction=create_junction),
}
import_module, open_file, symlink = builtins.__import__, io.open, os.symlink


def import_as_on_windows(name: str, globals: Any = None, locals: Any = None, fromlist: Any = (), level: int = 0) -> Any:
    importer = (globals or {}).get("__package__") or (globals or {}).get("__name__") or ""
    if level == 0 and importer.partition(".")[0] in OWN:
        if name in ABSENT:
            raise ModuleNotFoundError(f"No module named {name!r} on Windows", name=name)
        if name in VIEWS:
            return VIEWS[name]
    return import_module(name, globals, locals, fromlist, level)


def open_as_on_windows(
    file: Any, mode: str = "r", buffering: int = -1, encoding: str | None = None, errors: str | None = None,
    newline: str | None = None, closefd: bool = True, opener: Any = None,
) -> Any:  # fmt: skip
    if "b" not in mode:
        encoding = "cp1252" if encoding in (None, "locale") else encoding
        newline = "\r\n" if newline is None and "r" not in mode else newline
    return open_file(file, mode, buffering, encoding, errors, newline, closefd, opener)


def refuse_link(*_: Any, **__: Any) -> None:
    raise OSError(*INVALID)


def is_open(path: Any) -> bool:
    """True where this process has the file open, or one in this folder."""
    there = Path(os.fsdecode(path))
    place = str(there.parent.resolve() / there.name)
    for entry in Path("/proc/self/fd").iterdir():
        with suppress(OSError):  # the descriptor that listed the folder is closed by now
            other = str(entry.readlink())
            if other == place or other.startswith(f"{place}/"):
                return True
    return False


def closed_only(call: Callable[..., Any]) -> Callable[..., Any]:
    """The call, for files that are not open."""

    def checked(*paths: Any, **options: Any) -> Any:
        for path in paths:
            if isinstance(path, str | bytes | os.PathLike) and is_open(path):
                raise OSError(*DENIED, os.fsdecode(path))
        return call(*paths, **options)

    return checked


builtins.__import__ = import_as_on_windows
builtins.open = io.open = open_as_on_windows
locale.getpreferredencoding = lambda do_setlocale=True: "cp1252"
os.symlink = refuse_link
for name in ("replace", "rename", "unlink", "remove", "rmdir"):
    setattr(os, name, closed_only(getattr(os, name)))
shutil._use_fd_functions = False
