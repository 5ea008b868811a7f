"""How often this program was suspended, with Ctrl-Z for example, and continued."""

from __future__ import annotations

import signal
import threading
from types import FrameType

_count = 0


def count_suspensions() -> int:
    """Suspensions since the first call, which begins to count; only in the main thread can it."""
    if threading.current_thread() is threading.main_thread() and signal.getsignal(signal.SIGCONT) is signal.SIG_DFL:
        signal.signal(signal.SIGCONT, _continued)
    return _count


def _continued(_number: int, _: FrameType | None) -> None:
    global _count
    _count += 1
