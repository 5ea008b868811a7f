"""Size of the graph, and its cost so far."""

from typing import NamedTuple


class GraphSize(NamedTuple):
    """Counts of the back end."""

    keys: int = 0
    submaps: int = 0
    edges: int = 0
    loops: int = 0
    nbytes: int = 0
    """Memory of the key scans, bytes."""
    tried: int = 0
    """Pairs of submaps that were compared."""
    seconds: float = 0.0
    """Processor time of the searches, seconds."""
