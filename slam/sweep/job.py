"""One run of a sweep."""

import json
import shlex
from hashlib import sha256
from typing import Any, Final, Literal, Self

import yaml
from pydantic import Field

from slam.config import Section

_ID_LENGTH: Final = 16
"""Hexadecimal digits of an id: among a million jobs, two share one with a probability of one in ten million."""


def format_setting(key: str, value: Any) -> str:
    """Format ``key=value`` in the form of ``--set``; numbers keep all their digits."""
    text = yaml.safe_dump(value, default_flow_style=True, sort_keys=False, width=10**6).removesuffix("...\n")
    return f"{key}={text.strip()}"


class Job(Section):
    """Complete description of one run; it can be sent to another process, and repeated alone."""

    id: str
    """Hash of the content: the same in every process, and different for any other job."""
    kind: Literal["scenario", "log"]
    name: str
    """Name of the scenario, or of the log's file."""
    source: str
    """Argument of ``hopslam run`` or ``hopslam replay``."""
    mode: str
    seed: int
    grid: dict[str, Any] = Field({})
    """Values of the settings in the grid."""
    drawn: dict[str, Any] = Field({})
    """Values of the settings that were drawn."""
    settings: tuple[str, ...] = ()
    """All settings in the form of ``--set``, in order."""

    @classmethod
    def create(cls, input_digest: str, **content: Any) -> Self:
        """Make the job with its id; ``input_digest`` is that of the content of its source."""
        job = cls(id="", **content)
        canonical = json.dumps([job.kind, job.name, input_digest, job.settings, job.seed])
        return job.model_copy(update={"id": sha256(canonical.encode()).hexdigest()[:_ID_LENGTH]})

    @property
    def command(self) -> str:
        """Shell command that repeats this run alone."""
        settings = [word for text in self.settings for word in ("--set", text)]
        if self.kind == "scenario":
            return shlex.join(["hopslam", "run", self.source, "--seed", str(self.seed), *settings])
        return shlex.join(["hopslam", "replay", self.source, "--set", f"seed={self.seed}", *settings])
