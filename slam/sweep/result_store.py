"""Storage of a sweep's rows: each exactly once, whatever is killed when."""

import json
from collections.abc import Iterator
from pathlib import Path
from time import monotonic
from typing import Final

from slam.errors import InputError
from slam.sweep.folder import Folder
from slam.sweep.result_rows import BATCH, Row, read_rows, write_table

RESULTS: Final = "results.parquet"
_JOURNAL: Final = "rows"
_COMPACTION_PERIOD: Final = 30.0
"""Seconds after which the results are brought up to date, while there are few new rows."""


class ResultStore:
    """``results.parquet`` in a folder, by path or URL, and beside it a journal of the rows that it does not have yet.

    A row is first a small file of its own in ``rows``, named by its job's id and written whole. Then and when a new
    ``results.parquet`` takes the place of the old, with these rows, and they are removed. Killed in between, a row is
    in both: the journal's counts. A row of an id that is there already takes the place of the other.
    """

    def __init__(self, folder: Folder) -> None:
        self.folder = folder
        self._journal = folder / _JOURNAL
        self._waiting = len(self._journal.names())
        self._compacted = monotonic()

    def add(self, row: Row) -> None:
        """Keep a row; when this returns, it is on the disk."""
        self._journal.write(f"{row['id']}.json", json.dumps(row))
        self._waiting += 1
        if self._waiting >= BATCH or monotonic() - self._compacted > _COMPACTION_PERIOD:
            self.compact()

    def compact(self) -> None:
        """Take the journal into ``results.parquet``. InputError where that file was made by something else."""
        names = self._journal.names()
        if names:
            with self.folder.draft() as draft:
                self._write(draft / RESULTS, names)
                self.folder.move_in(draft / RESULTS, RESULTS)
            for name in names:
                self._journal.remove(name)
        self._waiting, self._compacted = 0, monotonic()

    def rows(self, columns: list[str] | None = None) -> Iterator[Row]:
        """Rows of ``results.parquet``, one after another: all but those added since it was last compacted."""
        try:
            with self.folder.open(RESULTS) as file:
                yield from read_rows(file, columns)
        except FileNotFoundError:
            return

    def done(self) -> set[str]:
        """Ids of the jobs that need not be run again: those in the file that did not fail."""
        return {row["id"] for row in self.rows(["id", "status"]) if row["status"] == "done"}

    def _write(self, path: Path, names: list[str]) -> None:
        ids = {name.removesuffix(".json") for name in names}
        try:
            old = self.folder.open(RESULTS)
        except FileNotFoundError:
            write_table(path, None, ids, lambda: self._batches(names))
            return
        with old:
            try:
                write_table(path, old, ids, lambda: self._batches(names))
            except (KeyError, ValueError) as error:
                raise InputError(f"{self.folder.address}/{RESULTS}: not the results of a sweep: {error}") from error

    def _batches(self, names: list[str]) -> Iterator[list[Row]]:
        for first in range(0, len(names), BATCH):
            texts = (self._journal.read(name) for name in names[first : first + BATCH])
            yield [json.loads(text) for text in texts if text is not None]
