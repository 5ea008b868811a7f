"""Rows of a sweep's results, and the Parquet file that holds them.

A row has plain values, as in JSON. The file is rewritten from the old one and new rows, with one batch in memory.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, Final, TypeAlias

from slam.modes import MODES
from slam.named_code import import_optional
from slam.run.results.metric_table import METRICS
from slam.sweep.job import Job, format_setting

if TYPE_CHECKING:
    from slam.run.experiment import Outcome

Row: TypeAlias = dict[str, Any]
"""Columns by name: ``id``, ``name``, ``source``, ``kind``, ``mode``, ``seed``; ``set.<key>`` and ``drawn.<key>`` for
settings; ``status`` (``done`` or ``failed``), ``ending``, ``error``, ``tries``; every number of ``metrics.json`` by its
name, with ``wall.`` before those of WALL_TIMES; ``error_m``: the error along the path, (CURVE_POINTS,); ``seconds``,
``host`` and ``version``; ``settings`` and ``command``, which repeat the run."""

WALL_TIMES: Final = frozenset(
    {"slam_ms_median", "slam_ms_p99", "slam_s_total", "extraction_ms_median", "real_time_factor", "closing_s"}
)
"""Metrics that are wall times, which differ in every run; all others have the same bits when a run is repeated."""
_OTHER_COLUMNS: Final = frozenset({"seed", "version", "ending"})
"""Metrics that a row has in other columns."""
_KINDS: Final = {
    "id": str, "name": str, "source": str, "kind": str, "mode": str, "seed": int, "status": str, "command": str,
}  # fmt: skip
"""Columns that every row has."""
_LISTS: Final = frozenset({"settings", "error_m"})
_LARGEST: Final = 2.0**63
BATCH: Final = 200
"""Largest number of rows in memory, and in a row group of the file."""


def job_columns(job: Job) -> Row:
    """Return the columns that describe the job."""
    row = job.model_dump(include={"id", "name", "source", "kind", "mode", "seed"})
    row |= {f"set.{key}": _plain(value) for key, value in job.grid.items()}
    row |= {f"drawn.{key}": _plain(value) for key, value in job.drawn.items()}
    return row | {"settings": list(job.settings), "command": job.command}


def done_row(job: Job, outcome: Outcome) -> Row:
    """Make the row of a completed run; ``failed`` if the robot failed."""
    metrics = {
        f"wall.{key}" if key in WALL_TIMES else key: value
        for key, value in outcome.metrics.items()
        if isinstance(value, int | float) and key not in _OTHER_COLUMNS
    }
    error = None if outcome.error is None else str(outcome.error)
    status = "done" if error is None else "failed"
    return job_columns(job) | {"status": status, "ending": outcome.ending, "error": error} | metrics


def failed_row(job: Job, error: str) -> Row:
    """Make the row of a run that was not completed."""
    return job_columns(job) | {"status": "failed", "ending": None, "error": error}


def repeatable_columns(row: Row) -> Row:
    """Return the columns that must be equal when the run is repeated: all but times, and those without a value."""
    excluded = {"seconds", "host", "tries", "started", "version", "command"}
    return {
        key: value
        for key, value in row.items()
        if value is not None and key not in excluded and not key.startswith(("wall.", "set.", "drawn."))
    }


def write_table(path: Path, old: IO[bytes] | None, ids: set[str], batches: Callable[[], Iterable[list[Row]]]) -> None:
    """Write the rows of ``old``, without those of ``ids``, and the new ones of ``batches``, which is called twice.

    A column has the widest type of its rows; missing values are null.
    """
    pq, before = import_optional("pyarrow.parquet", "sweep"), _open(old)
    schema = _schema(before, batches())
    with pq.ParquetWriter(path, schema, compression="zstd") as writer:
        for table in _gathered(_old_tables(before, ids, schema)):
            writer.write_table(table)
        for rows in batches():
            writer.write_table(_conformed(_table(rows), schema))


def read_rows(file: IO[bytes], columns: list[str] | None = None) -> Iterator[Row]:
    """Yield the rows of a results file, with all columns or these; ValueError if it is damaged."""
    arrow_error = import_optional("pyarrow", "sweep").ArrowException
    try:
        for batch in _open(file).iter_batches(batch_size=BATCH, columns=columns):
            yield from batch.to_pylist()
    except (arrow_error, OSError, ValueError, LookupError) as error:
        raise ValueError(f"{error}") from error


def whole_rows(file: IO[bytes]) -> tuple[list[Row], bool]:
    """Return the rows of the readable row groups of a results file, and True if all row groups are readable."""
    arrow_error = import_optional("pyarrow", "sweep").ArrowException
    damage = (arrow_error, OSError, ValueError, LookupError)
    rows, whole = list[Row](), True
    try:
        table = _open(file)
        groups = range(table.num_row_groups)
    except damage:
        return [], False
    for group in groups:
        try:
            found = table.read_row_group(group).to_pylist()
        except damage:
            whole = False
            continue
        good = [row for row in found if row_fault(row) is None]
        rows, whole = rows + good, whole and len(good) == len(found)
    return rows, whole


def row_fault(row: Any) -> str | None:
    """Describe the fault of a row; None if there is none."""
    if not isinstance(row, dict):
        return "is not an object"
    for name, kind in _KINDS.items():
        if not isinstance(row.get(name), kind) or isinstance(row.get(name), bool):
            return f"{name} is {str(row.get(name))[:20]!r}"
    if row["status"] not in ("done", "failed") or row["mode"] not in MODES:
        return f"status is {row['status'][:20]!r}, mode {row['mode'][:20]!r}"
    return next(
        (f"{name} is no text, number or list of such" for name, value in row.items() if not _is_plain(name, value)),
        None,
    )


def _is_plain(name: str, value: Any) -> bool:
    """Return True for the value of a column: text, a number within limits, or a list of such."""
    if name in METRICS and not (value is None or isinstance(value, int | float)):
        return False
    if name in _LISTS:
        kind = str if name == "settings" else int | float
        return value is None or (isinstance(value, list) and all(isinstance(item, kind) for item in value))
    return value is None or isinstance(value, str) or (isinstance(value, int | float) and abs(value) < _LARGEST)


def _plain(value: Any) -> Any:
    """Convert a value to a number or text."""
    return value if isinstance(value, int | float | str) else format_setting("", value)[1:]


def _open(file: IO[bytes] | None) -> Any:
    return None if file is None else import_optional("pyarrow.parquet", "sweep").ParquetFile(file)


def _table(rows: list[Row]) -> Any:
    """Make an Arrow table of the rows; columns with values of several kinds become text."""
    pa = import_optional("pyarrow", "sweep")
    names = dict.fromkeys(name for row in rows for name in row)
    return pa.table({name: _column(pa, [row.get(name) for row in rows]) for name in names})


def _column(pa: Any, values: list[Any]) -> Any:
    booleans = {isinstance(value, bool) for value in values if value is not None}
    try:
        if len(booleans) < 2:  # mixed: pyarrow would convert False to 0
            return pa.array(values)
    except (pa.ArrowInvalid, pa.ArrowTypeError):
        pass
    return pa.array([_text(value) for value in values])


def _text(value: Any) -> str | None:
    """Convert a value as a cast of the whole column would."""
    if isinstance(value, bool):
        return str(value).lower()
    return None if value is None else str(value)


def _schema(before: Any, batches: Iterable[list[Row]]) -> Any:
    pa = import_optional("pyarrow", "sweep")
    schema = pa.schema([]) if before is None else before.schema_arrow
    for rows in batches:
        schema = _unified(pa, schema, _table(rows).schema)
    return schema.remove_metadata()


def _unified(pa: Any, one: Any, other: Any) -> Any:
    names = dict.fromkeys([*one.names, *other.names])
    return pa.schema(
        [_wider(pa, name, [s.field(name).type for s in (one, other) if name in s.names]) for name in names]
    )


def _wider(pa: Any, name: str, types: list[Any]) -> Any:
    """Return the field for values of all these types: text, if nothing else fits."""
    try:
        fields = [pa.schema([(name, kind)]) for kind in types]
        return pa.unify_schemas(fields, promote_options="permissive").field(0)
    except (pa.ArrowInvalid, pa.ArrowTypeError):
        return pa.field(name, pa.string())


def _conformed(table: Any, schema: Any) -> Any:
    pa = import_optional("pyarrow", "sweep")
    columns = [
        table[field.name].cast(field.type) if field.name in table.column_names else pa.nulls(len(table), field.type)
        for field in schema
    ]
    return pa.table(columns, schema=schema)


def _old_tables(before: Any, ids: set[str], schema: Any) -> Iterator[Any]:
    pa, compute = import_optional("pyarrow", "sweep"), import_optional("pyarrow.compute", "sweep")
    if before is None:
        return
    newer = pa.array(sorted(ids), pa.string())
    for batch in before.iter_batches(batch_size=BATCH):
        table = pa.Table.from_batches([batch])
        yield _conformed(table.filter(compute.invert(compute.is_in(table["id"], newer))), schema)


def _gathered(tables: Iterable[Any]) -> Iterator[Any]:
    """Join small tables until there is a batch of rows."""
    pa = import_optional("pyarrow", "sweep")
    waiting: list[Any] = []
    for table in tables:
        waiting.append(table)
        if sum(map(len, waiting)) >= BATCH:
            yield pa.concat_tables(waiting).combine_chunks()
            waiting = []
    if waiting:
        yield pa.concat_tables(waiting).combine_chunks()
