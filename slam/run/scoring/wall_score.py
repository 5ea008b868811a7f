"""Score of a line map against the true walls of the world: precision and recall by length.

A piece of a mapped line **is wall** if a true face that faces the same way is nearer than NEAR, and is **in free
space** if no face at all is that near. Nothing is aligned: the map frame begins at the true start.
"""

from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from slam.pose import FloatArray
from slam.run.scoring.true_walls import TrueWalls
from slam.run.scoring.wall_pieces import NEAR, SAME_WAY, Pieces, covered, judge, lengths_once, longest_free

MIN_WALL: Final = 0.2
"""Least length of a face that the map must have, metres; legs and round things have shorter ones."""
BEYOND: Final = 0.2
"""A wall ends where no other face with the same direction begins within this distance, metres."""
WHOLE: Final = 0.95
"""Share of a face that must be seen for its length to be known."""


class WallScore(NamedTuple):
    """Agreement of the lines of a map with the walls; metres."""

    mapped: float
    """Length of all lines of the map."""
    right: float
    """Length of the part of them that is wall."""
    seen: float
    """Length of the walls that were seen."""
    found: float
    """Length of the part of them that is in the map."""
    length_errors: FloatArray
    """(L,): mapped length minus true length, for every wall that was seen completely and is in the map."""
    whole_lengths: FloatArray
    """(L,): their true lengths."""
    end_errors: FloatArray
    """(K,): distance from every end of a wall that was seen, and is in the map, to the nearest line end on that
    wall."""
    doubled: float
    """Length mapped on walls in addition to the first line there."""
    free_air: float
    """Length of lines in free space."""
    phantom: float
    """Length of the longest such piece of a line."""

    @property
    def precision(self) -> float:
        """Share of the mapped length that is wall; nan for an empty map."""
        return self.right / self.mapped if self.mapped > 0.0 else float("nan")

    @property
    def length_error_share(self) -> float:
        """Sum of the length errors of the completely seen walls, as a share of their length.

        It is nan if there are none.
        """
        total = float(self.whole_lengths.sum())
        return float(np.abs(self.length_errors).sum()) / total if total > 0.0 else float("nan")

    @property
    def recall(self) -> float:
        """Share of the seen walls that is in the map; nan if none was seen."""
        return self.found / self.seen if self.seen > 0.0 else float("nan")


def score_walls(walls: TrueWalls, seen: NDArray[np.bool_], lines: FloatArray) -> WallScore:
    """Score the mapped lines (M, 2, 2), each with the lidar's side to its left.

    ``seen`` (N,) marks the samples of the walls that the map should have.
    """
    lines = lines[np.isfinite(lines).all(axis=(1, 2))]
    pieces = judge(lines, walls.faces)
    lengths = walls.lengths
    required = seen & (lengths >= MIN_WALL)[walls.face_of]
    found = required & covered(walls.samples, walls.face_of, walls.faces, lines)
    once = lengths_once(pieces, walls.faces)
    on_walls = float(pieces.length[pieces.face >= 0].sum())
    whole = _seen_whole(walls, required) & (once > 0.0)
    return WallScore(
        mapped=float(pieces.length.sum()),
        right=on_walls,
        seen=float(walls.weights[required].sum()),
        found=float(walls.weights[found].sum()),
        length_errors=(once - lengths)[whole],
        whole_lengths=lengths[whole],
        end_errors=_end_errors(walls, required, pieces, lines),
        doubled=float(np.diff(pieces.span[pieces.face >= 0]).sum() - once.sum()),
        free_air=float(pieces.length[pieces.free].sum()),
        phantom=longest_free(pieces),
    )


def wall_metrics(score: WallScore) -> dict[str, Any]:
    """Return the score in the form of ``metrics.json``; None for unknown values."""
    ends, lengths = score.end_errors, np.abs(score.length_errors)
    values = {
        "wall_precision": score.precision,
        "wall_recall": score.recall,
        "wall_length_error_m": np.median(lengths) if len(lengths) else np.nan,
        "wall_end_error_m": np.median(ends) if len(ends) else np.nan,
        "wall_end_error_p90_m": np.percentile(ends, 90) if len(ends) else np.nan,
        "wall_doubled_m": score.doubled,
        "wall_free_air_m": score.free_air,
        "wall_phantom_m": score.phantom,
        "wall_mapped_m": score.mapped,
        "wall_seen_m": score.seen,
    }
    return {name: round(float(value), 4) if np.isfinite(value) else None for name, value in values.items()}


def _seen_whole(walls: TrueWalls, required: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return True for the faces whose length is known, (F,)."""
    seen = np.bincount(walls.face_of, walls.weights * required, len(walls.faces))
    return np.asarray(seen >= WHOLE * walls.lengths)


def _end_errors(walls: TrueWalls, required: NDArray[np.bool_], pieces: Pieces, lines: FloatArray) -> FloatArray:
    on = pieces.face >= 0
    face, line = np.unique(np.column_stack([pieces.face[on], pieces.line[on]]), axis=0).reshape(-1, 2).T
    first = np.searchsorted(walls.face_of, np.arange(len(walls.faces) + 1))
    are_ends, errors = wall_ends(walls), []
    for f in np.unique(face):
        ends = lines[line[face == f]].reshape(-1, 2)
        samples = first[f], first[f + 1] - 1
        for end, is_end, sample in zip(walls.faces[f], are_ends[f], samples, strict=True):
            if is_end and required[sample]:
                errors.append(np.hypot(*(ends - end).T).min())
    return np.array(errors)


def wall_ends(walls: TrueWalls) -> NDArray[np.bool_]:
    """Return True for the starts and ends of faces beyond which no other continues, (F, 2).

    The wall continues behind a thin wall that touches it, and at a small step such as that of a closed door.
    """
    along = (walls.faces[:, 1] - walls.faces[:, 0]) / walls.lengths[:, None]
    beyond = walls.faces + BEYOND * np.stack([-along, along], axis=1)
    order = np.argsort(walls.samples[:, 0])
    samples, ways = walls.samples[order], along[walls.face_of[order]]
    first = np.searchsorted(samples[:, 0], beyond[..., 0] - NEAR)
    last = np.searchsorted(samples[:, 0], beyond[..., 0] + NEAR, side="right")
    ends = np.ones(first.shape, np.bool_)
    for place in np.ndindex(*ends.shape):
        strip = slice(first[place], last[place])
        near = np.hypot(*(samples[strip] - beyond[place]).T) <= NEAR
        ends[place] = not np.any(ways[strip][near] @ along[place[0]] >= SAME_WAY)
    return ends
