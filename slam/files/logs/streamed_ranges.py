"""Ranges of the scans of a log, read from its file again on request."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from slam.errors import LogError
from slam.files.fields import BadLine
from slam.pose import FloatArray

_RECENT: Final = 16
"""Number of rows kept in memory, for small steps back."""
Part = TypeVar("Part")


class StreamedRanges:
    """Rows of ranges, metres, one for each scan of a log, of which only the last few are in memory.

    They are read in the order of the file; a larger step back reads it again from the start. ``numpy.asarray`` reads
    all of them, shorter rows padded with nan; another process gets that array.
    """

    def __init__(self, path: Path, rows: Callable[[], Iterator[FloatArray]], beams: Iterable[int]) -> None:
        """Keep ``rows``, which reads the file again, and ``beams``, the lengths of its rows."""
        self._path = path
        self._read = rows
        self._beams = np.fromiter(beams, np.int64)
        self._rows: Iterator[FloatArray] = iter(())
        self._next = len(self._beams)
        self._recent: deque[FloatArray] = deque(maxlen=_RECENT)

    @property
    def shape(self) -> tuple[int, int]:
        """Number of scans, and of the beams of the longest."""
        return len(self._beams), int(self._beams.max())

    def __len__(self) -> int:
        return len(self._beams)

    def __getitem__(self, index: int) -> FloatArray:
        """Return row ``index``, read-only. LogError if the file has changed."""
        index = range(len(self))[index]
        if index < self._next - len(self._recent):
            self._rows, self._next = self._read(), 0
            self._recent.clear()
        while self._next <= index:
            self._recent.append(self._read_next())
        return self._recent[index - self._next]

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        ranges = np.full(self.shape, np.nan)
        for index, beams in enumerate(self._beams.tolist()):
            ranges[index, :beams] = self[index]
        return ranges if dtype is None else ranges.astype(dtype)

    def __reduce__(self) -> tuple[Callable[[FloatArray], FloatArray], tuple[FloatArray]]:
        return np.asarray, (np.asarray(self),)

    def _read_next(self) -> FloatArray:
        try:
            row = next(self._rows, None)
        except (BadLine, OSError):
            row = None
        if row is None or len(row) != self._beams[self._next]:
            raise LogError(f"{self._path}: was changed while it was read; run the command again")
        row.flags.writeable = False
        self._next += 1
        if self._next == len(self):
            self._rows = iter(())  # closes the file
        return row


def at_places(parts: Iterable[tuple[int, Part]], places: Iterable[int]) -> Iterator[Part]:
    """Yield the numbered parts of a file at these increasing places."""
    wanted = iter(places)
    place = next(wanted, None)
    for number, part in parts:
        if number == place:
            yield part
            if (place := next(wanted, None)) is None:
                return
