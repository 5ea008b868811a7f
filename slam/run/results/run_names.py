"""Names that distinguish runs, by the differences between them."""

from collections.abc import Iterator, Mapping, Sequence
from datetime import datetime
from typing import Any, Final

from slam.run.results.run_record import RunRecord

_NAMED: Final = 3
"""Number of differing settings that are listed; the others are counted."""
_LONGEST: Final = 24
"""Number of characters of a value that are shown."""


def run_names(records: Sequence[RunRecord]) -> list[str]:
    """Name each run by its scenario and, if several share one, by what differs: seed, settings, date, folder."""
    names = [record.config.name for record in records]
    for details in (_settings, _dates, _folders):
        for shared in {name for name in names if names.count(name) > 1}:
            alike = [index for index, name in enumerate(names) if name == shared]
            for index, detail in zip(alike, details([records[index] for index in alike]), strict=True):
                names[index] = f"{shared}, {detail}" if detail else shared
    return names


def _settings(records: Sequence[RunRecord]) -> list[str]:
    """Return the settings that differ between these runs, for each run."""
    all_settings = [dict(_leaves(_whole(record))) for record in records]
    keys = dict.fromkeys(key for settings in all_settings for key in settings)
    differing = [key for key in keys if len({repr(settings.get(key)) for settings in all_settings}) > 1]
    named, rest = differing[:_NAMED], len(differing) - _NAMED
    more = [f"{rest} more settings"] if rest > 0 else []
    return [", ".join([*(_setting(key, settings.get(key)) for key in named), *more]) for settings in all_settings]


def _whole(record: RunRecord) -> dict[str, Any]:
    """Return the seed, the settings, and other arguments of the run."""
    given = {key: (record.metrics or {}).get(key) for key in ("backend", "log", "map", "start")}
    return {"seed": record.config.seed, **record.config.model_dump(mode="json", exclude={"description"}), **given}


def _leaves(values: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in values.items():
        if isinstance(value, dict):
            yield from _leaves(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def _setting(key: str, value: Any) -> str:
    """Shorten a setting: the key without its sections, and the beginning of a long value."""
    text = "none" if value is None else str(value)
    short = text if len(text) <= _LONGEST else f"{text[: _LONGEST - 1]}…"
    return f"seed {short}" if key == "seed" else f"{key.rpartition('.')[2]}={short}"


def _dates(records: Sequence[RunRecord]) -> list[str]:
    """Return date and time at which each run began; empty if all began together."""
    began = [str((record.metrics or {}).get("began", "")) for record in records]
    times = [datetime.fromisoformat(text).strftime("%Y-%m-%d %H:%M:%S") if text else "cut off" for text in began]
    return times if len(set(times)) > 1 else [""] * len(times)


def _folders(records: Sequence[RunRecord]) -> list[str]:
    return [str(record.folder) for record in records]
