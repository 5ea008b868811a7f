"""Executor that runs jobs as tasks of a Ray cluster."""

import json
import logging
import os
import platform
import socket
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, Final

from slam.errors import ClusterError, InputError
from slam.named_code import import_optional
from slam.sweep.code_bundle import CodeBundle, version_difference, versions
from slam.sweep.executor import FinishedJob, LostJob
from slam.sweep.job import Job
from slam.sweep.process_pool import ONE_THREAD

LOCAL: Final = "local"
"""Value of ``address`` for a new cluster on this machine, for this sweep only."""
MEMORY: Final = 500 * 2**20
"""Memory that a task requests, bytes: that of a run with its libraries, plus half."""
_WAITING: Final = 1.25
"""Tasks per processor that are submitted to the cluster: some wait there, so that no processor is idle."""


class RayCluster:
    """The cluster at ``address``, or, for ``local``, a new one of ``jobs`` processors on this machine.

    The code is sent to other machines, with the ``files`` that the jobs name; ``allowed`` is the user's own code that
    may run there. InputError if there is no cluster, or one with another version of Ray or Python; ClusterError if it
    is lost, or its packages differ from those here.
    """

    def __init__(
        self,
        address: str,
        jobs: int,
        runs: str,
        pictures: bool,
        files: Iterable[Path] = (),
        allowed: Sequence[str] = (),
    ) -> None:
        os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
        os.environ.setdefault("RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO", "0")  # the new default of Ray; if unset, Ray warns
        if address == LOCAL:
            os.environ["RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER"] = "0"  # makes Ray use the loopback interface, on Linux too
        self._ray = import_optional("ray", "cluster")
        self._runs, self._pictures, self._allowed = runs, pictures, list(allowed)
        self._bundle = None if address == LOCAL else CodeBundle(files)
        self._pending: dict[Any, Job] = {}
        _check_reachable(address)
        self._connect(address, jobs)
        remote = self._ray.remote(num_cpus=1, memory=MEMORY, max_retries=0)
        self._run = remote(run_on_cluster)

    @property
    def free(self) -> int:
        """Number of tasks that can be submitted now: one per processor, plus those that wait."""
        processors = int(self._ray.cluster_resources().get("CPU", 0))
        return max(int(_WAITING * processors + 0.999) - len(self._pending), 0)

    @property
    def busy(self) -> int:
        """Number of unfinished tasks."""
        return len(self._pending)

    def submit(self, job: Job) -> None:
        """Start a task for the job."""
        task = self._run.remote(job.model_dump_json(), self._runs, self._pictures, versions(), self._allowed)
        self._pending[task] = job

    def collect(self, timeout: float) -> Iterator[FinishedJob | LostJob]:
        """See Executor."""
        ready, _ = self._ray.wait(list(self._pending), timeout=timeout)
        for task in ready:
            yield self._result(task, self._pending.pop(task))

    def close(self) -> None:
        """Cancel all tasks and disconnect; a cluster that was started for this sweep is shut down."""
        self._ray.shutdown()
        if self._bundle is not None:
            self._bundle.close()

    def _connect(self, address: str, jobs: int) -> None:
        runtime_env: dict[str, Any] = {"env_vars": ONE_THREAD}
        options: dict[str, Any] = {"num_cpus": jobs, "include_dashboard": False, "_node_ip_address": "127.0.0.1"}
        if self._bundle is not None:
            runtime_env["working_dir"] = str(self._bundle.folder)
            options = {"address": address}
        options["runtime_env"] = runtime_env
        try:
            self._ray.init(**options, logging_level=logging.ERROR, log_to_driver=False, configure_logging=False)
        except (ConnectionError, RuntimeError, ValueError, self._ray.exceptions.RayError) as error:
            raise InputError(f"--ray {address}: {_first_line(error)}; start one: ray start --head") from error

    def _result(self, task: Any, job: Job) -> FinishedJob | LostJob:
        problems = self._ray.exceptions
        try:
            answer = json.loads(self._ray.get(task))
        except problems.RayTaskError as error:
            reason = str(error).strip().splitlines()[-1]
            raise ClusterError(f"a machine of the cluster cannot run jobs: {reason}") from error
        except problems.RuntimeEnvSetupError as error:
            raise ClusterError(f"a machine of the cluster cannot take the code: {_first_line(error)}") from error
        except problems.RayError as error:
            return LostJob(job, f"the worker died: {_first_line(error)}")
        if "versions" in answer:
            differs = version_difference(versions(), answer["versions"])
            raise ClusterError(f"{answer['host']} has {differs}; install the same versions there, or leave it out")
        return LostJob(job, "the run was interrupted") if answer["row"] is None else FinishedJob(job, answer["row"])


def run_on_cluster(job: str, runs: str, pictures: bool, expected: dict[str, str], allowed: Sequence[str] = ()) -> str:
    """Run a job as a task; return JSON of its row, or of host and versions if these differ from ``expected``."""
    if version_difference(expected, versions()):
        return json.dumps({"host": platform.node(), "versions": versions()})
    from slam.sweep.run_job import run_job

    os.chdir("/")  # a second Ray node on this machine rewrites the working directory, so jobs must not run in it
    return json.dumps({"row": run_job(Job.model_validate_json(job), runs, pictures, allowed)})


def _check_reachable(address: str) -> None:
    """Fail at once if nothing listens there; Ray itself waits for minutes."""
    host, _, port = address.rpartition(":")
    if not port.isdigit() or "/" in host:
        return
    try:
        socket.create_connection((host, int(port)), timeout=5.0).close()
    except (OSError, OverflowError) as error:
        raise InputError(f"--ray {address}: {error}; start a cluster there: ray start --head") from error


def _first_line(error: Exception) -> str:
    return str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
