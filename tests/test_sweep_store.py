"""Rows of a sweep: each is stored exactly once, whichever process is killed."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any
from uuid import uuid4

import pyarrow.parquet as pq
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from slam.errors import InputError
from slam.sweep import result_rows
from slam.sweep.folder import Folder
from slam.sweep.lock import SweepLock
from slam.sweep.result_store import RESULTS, ResultStore

numbers = st.one_of(st.none(), st.integers(-100, 100), st.just(0.5), st.text("ab"), st.booleans())
rows = st.lists(st.tuples(st.sampled_from("abcdefg"), st.dictionaries(st.sampled_from(["x", "y", "set.z"]), numbers)))


@pytest.fixture(params=["path", "url"])
def new_folder(request: pytest.FixtureRequest, tmp_path: Path) -> Callable[[], Folder]:
    """Makes empty folders: on the disk, and at a URL that fsspec serves from memory."""
    place = str(tmp_path) if request.param == "path" else "memory://sweeps"
    return lambda: Folder(f"{place}/{uuid4().hex}")


def row(run: str, **values: Any) -> dict[str, Any]:
    return {"id": run, "status": "done", **values}


@settings(max_examples=10, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(rows, max_size=4))
def test_only_the_last_row_of_an_id_is_read(
    new_folder: Callable[[], Folder], batches: list[list[tuple[str, dict[str, Any]]]]
) -> None:
    """This holds however often the journal is compacted in between, and whatever columns the rows have."""
    folder, expected = new_folder(), {}
    for batch in batches:
        store = ResultStore(folder)  # another driver each time
        for run, values in batch:
            store.add(row(run, **values))
            expected[run] = values
        store.compact()
    kept = list(ResultStore(folder).rows())
    assert sorted(r["id"] for r in kept) == sorted(expected)
    for r in kept:
        for name, value in expected[r["id"]].items():
            assert r[name] == value or r[name] == (str(value).lower() if isinstance(value, bool) else str(value))


def test_a_row_stored_twice_is_read_once(tmp_path: Path) -> None:
    """A process killed between writing the table and removing the journal leaves the row in both."""
    store = ResultStore(Folder(str(tmp_path)))
    store.add(row("a", x=1))
    journal = next((tmp_path / "rows").iterdir())
    text = journal.read_text()
    store.compact()
    journal.write_text(text)
    again = ResultStore(Folder(str(tmp_path)))
    again.compact()
    assert [r["x"] for r in again.rows()] == [1]
    assert not list((tmp_path / "rows").iterdir())


def test_numbers_keep_their_bits(tmp_path: Path) -> None:
    store = ResultStore(Folder(str(tmp_path)))
    store.add(row("a", x=0.1 + 0.2, n=3, error_m=[0.1, 1e-17]))
    store.compact()
    store.add(row("b", x=1, n=2.5))
    store.compact()
    a, b = sorted(store.rows(), key=lambda r: str(r["id"]))
    assert (a["x"], a["n"], a["error_m"]) == (0.1 + 0.2, 3.0, [0.1, 1e-17])
    assert (b["x"], b["n"], b["error_m"]) == (1.0, 2.5, None)


def test_failed_jobs_do_not_count_as_done(tmp_path: Path) -> None:
    store = ResultStore(Folder(str(tmp_path)))
    store.add(row("a"))
    store.add(row("b") | {"status": "failed"})
    store.compact()
    assert store.done() == {"a"}


def test_single_rows_are_merged_into_row_groups(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(result_rows, "BATCH", 10)
    store = ResultStore(Folder(str(tmp_path)))
    for index in range(35):
        store.add(row(f"{index}", x=index))
        store.compact()
    file = pq.ParquetFile(tmp_path / RESULTS)
    assert file.metadata.num_rows == 35
    assert file.metadata.num_row_groups <= 5


def test_a_folder_is_locked_by_one_process(new_folder: Callable[[], Folder]) -> None:
    folder = new_folder()
    with SweepLock(folder), pytest.raises(InputError, match="runs a sweep there"), SweepLock(folder):
        pass
    with SweepLock(folder):
        pass


def test_the_lock_of_a_dead_process_is_taken_over() -> None:
    folder = Folder(f"memory://sweeps/{uuid4().hex}")
    import platform

    folder.write("driver.lock", json.dumps({"host": platform.node(), "pid": 2**22 + 1}))
    with SweepLock(folder):
        pass
    folder.write("driver.lock", json.dumps({"host": "elsewhere", "pid": 1}))
    with pytest.raises(InputError, match="on elsewhere"), SweepLock(folder):
        pass


def test_bad_results_and_bad_folders_are_refused(tmp_path: Path) -> None:
    (tmp_path / RESULTS).write_text("no parquet")
    store = ResultStore(Folder(str(tmp_path)))
    store.add(row("a"))
    with pytest.raises(InputError, match=RESULTS):
        store.compact()
    with pytest.raises(InputError, match="nowhere"):
        Folder("nowhere://there")


def test_a_folder_stored_again_replaces_the_old_one(new_folder: Callable[[], Folder]) -> None:
    folder = new_folder()
    for text in ("old", "new"):
        with folder.draft() as draft:
            (draft / "run").mkdir()
            (draft / "run" / "metrics.json").write_text(text)
            folder.move_in(draft / "run", "run")
    assert (folder / "run").names() == ["metrics.json"]
    assert (folder / "run").read("metrics.json") == "new"
