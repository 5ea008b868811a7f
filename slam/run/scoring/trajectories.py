"""Sources of trajectories: the folder of a run, a TUM file, or a value that has one."""

from pathlib import Path
from typing import Protocol, runtime_checkable

from slam.errors import InputError, shown
from slam.files.tum import read_tum
from slam.pose import FloatArray
from slam.run.results.run_record import RunRecord
from slam.run.scoring.pose_errors import Trajectory


@runtime_checkable
class HasTrajectory(Protocol):
    """Any object with a trajectory: a run, or a map."""

    @property
    def stamps(self) -> FloatArray:
        """Stamps, (K,), seconds."""
        ...

    @property
    def trajectory(self) -> FloatArray:
        """Rows x, y, theta, (K, 3), metres and radians."""
        ...


Source = str | Path | HasTrajectory
"""A trajectory: the folder of a run, a TUM file, or an object that has one."""


def read_trajectory(source: Source) -> Trajectory:
    """Read the final trajectory of a run folder, the poses of a TUM file, or those of an object.

    InputError for anything else.
    """
    if isinstance(source, HasTrajectory):
        return Trajectory(source.stamps, source.trajectory)
    if not isinstance(source, str | Path):
        raise InputError(f"expected a run, or the path of a run folder or a TUM file (got {shown(source)})")
    if Path(source).is_dir():
        traces = RunRecord.open(source).traces
        return Trajectory(traces.stamps, traces.final)
    return Trajectory(*read_tum(Path(source)))


def trajectories_to_score(source: Source) -> dict[str, Trajectory]:
    """Return trajectories by the prefix of their scores' names.

    A run folder has the one estimated during the run and, if its loops were closed, the final one; any other source has
    a single one.
    """
    folder = getattr(source, "folder", source)
    if not isinstance(folder, str | Path) or not Path(folder).is_dir():
        return {"": read_trajectory(source)}
    traces = RunRecord.open(folder).traces
    known = {"": traces.estimate} if traces.closed is None else {"": traces.estimate, "closed: ": traces.closed}
    return {name: Trajectory(traces.stamps, poses) for name, poses in known.items()}


def reference_of(source: Source, given: Source | None) -> Trajectory:
    """Return the given reference, or the true trajectory of a run; InputError if there is none."""
    if given is not None:
        return read_trajectory(given)
    folder = getattr(source, "folder", source)
    if isinstance(folder, str | Path) and (truth := Path(folder) / "groundtruth.tum").is_file():
        return read_trajectory(truth)
    raise InputError(f"{folder}: has no true trajectory; give --reference FILE.tum or --relations FILE")
