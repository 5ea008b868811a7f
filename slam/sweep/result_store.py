"""Storage of a sweep's rows: each exactly once, even after kills."""

import json
from collections.abc import Iterator
from pathlib import Path
from time import monotonic
from typing import Final

from slam.errors import InputError
from slam.files.json_files import parse_json
from slam.sweep.folder import Folder
from slam.sweep.result_rows import BATCH, Row, read_rows, row_fault, whole_rows, write_table

RESULTS: Final = "results.parquet"
_JOURNAL: Final = "rows"
_COMPACTION_PERIOD: Final = 30.0
"""Seconds after which the results file is updated, if there are few new rows."""


class ResultStore:
    """``results.parquet`` in a folder, by path or URL, with a journal of the rows that are not in it yet.

    A row is first a small file of its own in ``rows``, named by its job's id and written at once or not at all. From
    time to time a new ``results.parquet`` with these rows replaces the old one, and they are removed. If the
    program is killed in between, a row is in both, and the journal's is used. A new row replaces one with the same id.
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

    def set_damaged_aside(self) -> list[str]:
        """Move unreadable files aside, so that their runs are made again; return a sentence for each such file.

        The readable rows of a damaged ``results.parquet`` are restored through the journal.
        """
        faults = {name: fault for name in self._journal.names() if (fault := self._journal_fault(name)) is not None}
        said = [
            f"{self._journal.address}/{name}: {fault}; it is now {self._journal.set_aside(name)}"
            for name, fault in faults.items()
        ]
        if RESULTS in self.folder.names():
            with self.folder.open(RESULTS) as file:
                rows, whole = whole_rows(file)
            if not whole:
                for row in rows:
                    self._journal.write(f"{row['id']}.json", json.dumps(row))
                aside = self.folder.set_aside(RESULTS)
                said.append(f"{self.folder.address}/{RESULTS}: damaged, {len(rows)} rows are whole; it is now {aside}")
        return said

    def compact(self) -> None:
        """Merge the journal into ``results.parquet``. InputError if that file is not a results file."""
        names = self._journal.names()
        if names:
            with self.folder.draft() as draft:
                self._write(draft / RESULTS, names)
                self.folder.move_in(draft / RESULTS, RESULTS)
            for name in names:
                self._journal.remove(name)
        self._waiting, self._compacted = 0, monotonic()

    def rows(self, columns: list[str] | None = None) -> Iterator[Row]:
        """Yield the rows of ``results.parquet``, without those added since it was last compacted.

        InputError if the file is damaged.
        """
        if RESULTS not in self.folder.names():
            return
        try:
            with self.folder.open(RESULTS) as file:
                yield from read_rows(file, columns)
        except (OSError, ValueError) as error:
            raise self._damaged(error) from error

    def done(self) -> set[str]:
        """Return ids of the jobs that need not run again: those in the file that did not fail."""
        return {row["id"] for row in self.rows(["id", "status"]) if row["status"] == "done"}

    def _write(self, path: Path, names: list[str]) -> None:
        ids = {name.removesuffix(".json") for name in names}
        old = self.folder.open(RESULTS) if RESULTS in self.folder.names() else None
        try:
            write_table(path, old, ids, lambda: self._batches(names))
        except (LookupError, ValueError) as error:
            raise self._damaged(error) from error
        finally:
            if old is not None:
                old.close()

    def _damaged(self, error: Exception) -> InputError:
        place = f"{self.folder.address}/{RESULTS}"
        return InputError(f"{place}: damaged, or not the results of a sweep: {error}; run the sweep again to mend it")

    def _journal_fault(self, name: str) -> str | None:
        """Describe the fault of a row of the journal; None if there is none."""
        try:
            with self._journal.open(name) as file:
                row = parse_json(file.read())
        except (OSError, ValueError) as error:
            return f"no row of a sweep: {error}"
        fault = row_fault(row)
        if fault is None and f"{row['id']}.json" != name:
            fault = f"id is {row['id'][:20]!r}"
        return fault and f"no row of a sweep: {fault}"

    def _batches(self, names: list[str]) -> Iterator[list[Row]]:
        for first in range(0, len(names), BATCH):
            texts = (self._journal.read(name) for name in names[first : first + BATCH])
            yield [json.loads(text) for text in texts if text is not None]
