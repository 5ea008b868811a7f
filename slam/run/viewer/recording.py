"""The recording of a run that is over: the one it left, or one made from its folder."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

from slam.errors import InputError
from slam.files.whole_files import whole_file
from slam.run.results.run_record import RunRecord

Track = Callable[[Iterable[int], int], Iterable[int]]
"""Shows the progress of something that has so many parts."""


def recording_of(folder: Path, track: Track) -> Path:
    """``run.rrd`` in the folder of a run, made if it is not there; InputError for what is no such folder."""
    path = folder / "run.rrd"
    if not path.is_file():
        make_recording(RunRecord.open(folder), path, track)
    return path


def make_recording(record: RunRecord, path: Path, track: Track) -> None:
    """Write a run, as its folder has it, to an .rrd file; InputError where that cannot be written."""
    from slam.run.viewer.broadcast import Broadcast
    from slam.run.viewer.finished import setting_of, show_finished

    try:
        with whole_file(path) as draft:
            draft.touch()
            with Broadcast([draft], [], setting_of(record), print) as broadcast:
                for _ in track(show_finished(record, broadcast), len(record.traces.stamps)):
                    pass
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}; give --rerun FILE.rrd elsewhere") from error
