"""Score of a line map against the true walls of the world: what of it is wall, and what of the wall it has.

A piece of a mapped line **is wall** where a true face that faces the same way is nearer than NEAR, and **hangs in free
air** where no face at all is. Nothing is aligned: the map frame begins at the true start.
"""

from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from slam.compiled import compiled
from slam.lines.segments import IntArray
from slam.pose import FloatArray
from slam.run.scoring.true_walls import TrueWalls

PIECE = 0.02  # metres: mapped lines are judged in pieces no longer than this
NEAR = 0.10  # metres: a piece is no farther from the face that it shows
SAME_WAY = float(np.cos(np.radians(20.0)))  # cosine between a mapped line and the face, both with their free side left
MIN_WALL: Final = 0.2
"""Metres: a face that is shorter, as those of legs and of round things, need not be in the map."""
BEYOND: Final = 0.2
"""Metres beyond the end of a face, where no other within NEAR must look the same way, for the wall to end there."""
WHOLE: Final = 0.95
"""Share of a face that was seen, for its length to be known."""


class WallScore(NamedTuple):
    """The agreement of the lines of a map with the walls; metres."""

    mapped: float
    """Length of all lines of the map ..."""
    right: float
    """... and of what of them is wall."""
    seen: float
    """Length of the walls that were seen ..."""
    found: float
    """... and of what of them is in the map."""
    length_errors: FloatArray
    """(L,) of every wall that was seen whole and is in the map: the length that is mapped on it less its own."""
    whole_lengths: FloatArray
    """Their own lengths, (L,)."""
    end_errors: FloatArray
    """(K,) from every end of a wall that was seen, and is in the map, to the nearest end of the lines on that wall."""
    doubled: float
    """Length mapped on walls beyond the first line there."""
    free_air: float
    """Length of lines in free air ..."""
    phantom: float
    """... and of the longest such piece of a line."""

    @property
    def precision(self) -> float:
        """Share of the mapped length that is wall; nan of an empty map."""
        return self.right / self.mapped if self.mapped > 0.0 else float("nan")

    @property
    def length_error_share(self) -> float:
        """Sum of what the walls that were seen whole are too long or too short, as a share of their length.

        It is nan where there is none.
        """
        total = float(self.whole_lengths.sum())
        return float(np.abs(self.length_errors).sum()) / total if total > 0.0 else float("nan")

    @property
    def recall(self) -> float:
        """Share of the seen walls that is in the map; nan where none was seen."""
        return self.found / self.seen if self.seen > 0.0 else float("nan")


class _Pieces(NamedTuple):
    """P pieces of the mapped lines."""

    line: IntArray
    """Line of each, (P,), which rises."""
    middle: FloatArray
    """(P, 2)."""
    length: FloatArray
    """(P,)."""
    span: FloatArray
    """Begin and end of each along its face, from the start of that on, (P, 2)."""
    face: IntArray
    """Nearest face that looks the same way, no farther than NEAR, (P,); -1 for none."""
    free: NDArray[np.bool_]
    """True where no face at all is as near, (P,)."""


def score_walls(walls: TrueWalls, seen: NDArray[np.bool_], lines: FloatArray) -> WallScore:
    """Score the mapped lines (M, 2, 2), each with the lidar's side to its left.

    ``seen`` (N,) marks the samples of the walls that the map should have.
    """
    lines = lines[np.isfinite(lines).all(axis=(1, 2))]
    pieces = _Pieces(*_judge(lines, walls.faces))
    lengths = walls.lengths
    required = seen & (lengths >= MIN_WALL)[walls.face_of]
    found = required & _covered(walls.samples, walls.face_of, walls.faces, lines)
    once = _lengths_once(pieces, walls.faces)
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
        phantom=_longest_free(pieces),
    )


def wall_metrics(score: WallScore) -> dict[str, Any]:
    """The score as ``metrics.json`` has it; None for what is not known."""
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


@compiled
def _judge(
    lines: FloatArray, faces: FloatArray
) -> tuple[IntArray, FloatArray, FloatArray, FloatArray, IntArray, NDArray[np.bool_]]:
    """The columns of _Pieces for the lines (M, 2, 2) and faces (F, 2, 2)."""
    M, F = len(lines), len(faces)
    counts = np.empty(M, np.int64)
    for m in range(M):
        counts[m] = np.ceil(np.hypot(lines[m, 1, 0] - lines[m, 0, 0], lines[m, 1, 1] - lines[m, 0, 1]) / PIECE)
    P = counts.sum()
    line, middle, length, span = np.empty(P, np.int64), np.empty((P, 2)), np.empty(P), np.zeros((P, 2))
    face, free = np.full(P, -1, np.int64), np.ones(P, np.bool_)
    near, cosine = np.empty(F, np.int64), np.empty(F)
    p = 0
    for m in range(M):
        dx, dy = lines[m, 1, 0] - lines[m, 0, 0], lines[m, 1, 1] - lines[m, 0, 1]
        whole = np.hypot(dx, dy)
        count = 0
        for f in range(F):
            if _boxes_near(lines[m], faces[f]):
                near[count] = f
                fx, fy = faces[f, 1, 0] - faces[f, 0, 0], faces[f, 1, 1] - faces[f, 0, 1]
                cosine[count] = (dx * fx + dy * fy) / (whole * np.hypot(fx, fy))
                count += 1
        for k in range(counts[m]):
            share = (k + 0.5) / counts[m]
            x, y = lines[m, 0, 0] + share * dx, lines[m, 0, 1] + share * dy
            line[p], middle[p, 0], middle[p, 1], length[p] = m, x, y, whole / counts[m]
            nearest = NEAR
            for c in range(count):
                distance = _distance(x, y, faces[near[c]])
                if distance <= NEAR:
                    free[p] = False
                if distance <= nearest and cosine[c] >= SAME_WAY:
                    face[p], nearest = near[c], distance
                    along, half = _place(x, y, faces[near[c]]), 0.5 * length[p] * cosine[c]
                    span[p, 0], span[p, 1] = along - half, along + half
            p += 1
    return line, middle, length, span, face, free


@compiled
def _boxes_near(a: FloatArray, b: FloatArray) -> bool:
    """True where the boxes about two lines (2, 2) are no farther apart than NEAR in x and in y."""
    for axis in range(2):
        if max(a[0, axis], a[1, axis]) + NEAR < min(b[0, axis], b[1, axis]):
            return False
        if max(b[0, axis], b[1, axis]) + NEAR < min(a[0, axis], a[1, axis]):
            return False
    return True


@compiled
def _distance(x: float, y: float, face: FloatArray) -> float:
    """Distance of (x, y) from the face (2, 2), which has a length."""
    fx, fy = face[1, 0] - face[0, 0], face[1, 1] - face[0, 1]
    px, py = x - face[0, 0], y - face[0, 1]
    along = min(max((px * fx + py * fy) / (fx * fx + fy * fy), 0.0), 1.0)
    return float(np.hypot(px - along * fx, py - along * fy))


@compiled
def _place(x: float, y: float, face: FloatArray) -> float:
    """Metres from the start of the face to the foot of (x, y) on its line."""
    fx, fy = face[1, 0] - face[0, 0], face[1, 1] - face[0, 1]
    return float(((x - face[0, 0]) * fx + (y - face[0, 1]) * fy) / np.hypot(fx, fy))


@compiled
def _covered(samples: FloatArray, face_of: IntArray, faces: FloatArray, lines: FloatArray) -> NDArray[np.bool_]:
    """True for each sample (N, 2) beside a line that looks the same way, no farther than NEAR from it, (N,)."""
    covered = np.zeros(len(samples), np.bool_)
    ways = faces[:, 1] - faces[:, 0]
    for m in range(len(lines)):
        x, y = lines[m, 0]
        dx, dy = lines[m, 1, 0] - x, lines[m, 1, 1] - y
        length = np.hypot(dx, dy)
        if not length > 0.0:
            continue
        dx, dy = dx / length, dy / length
        for n in range(len(samples)):
            if covered[n]:
                continue
            px, py = samples[n, 0] - x, samples[n, 1] - y
            along = px * dx + py * dy
            if along >= 0.0 and along <= length and abs(px * dy - py * dx) <= NEAR:
                fx, fy = ways[face_of[n]]
                covered[n] = fx * dx + fy * dy >= SAME_WAY * np.hypot(fx, fy)
    return covered


def _lengths_once(pieces: _Pieces, faces: FloatArray) -> FloatArray:
    """Length of each face (F,) on which a line lies, were it there once or more."""
    on = np.flatnonzero(pieces.face >= 0)
    on = on[np.lexsort([pieces.span[on, 0], pieces.face[on]])]
    return _unions(pieces.face[on], pieces.span[on], len(faces))


@compiled
def _unions(face: IntArray, spans: FloatArray, count: int) -> FloatArray:
    """Length of the union of the spans (Q, 2) of each face, sorted by face and begin, (F,)."""
    lengths, reach, last = np.zeros(count), 0.0, -1
    for q in range(len(face)):
        if face[q] != last:
            last, reach = face[q], spans[q, 0]
        lengths[last] += max(spans[q, 1] - max(spans[q, 0], reach), 0.0)
        reach = max(reach, spans[q, 1])
    return lengths


def _seen_whole(walls: TrueWalls, required: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """True for the faces whose length is known, (F,)."""
    seen = np.bincount(walls.face_of, walls.weights * required, len(walls.faces))
    return np.asarray(seen >= WHOLE * walls.lengths)


def _end_errors(walls: TrueWalls, required: NDArray[np.bool_], pieces: _Pieces, lines: FloatArray) -> FloatArray:
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
    """True for the starts and ends of faces beyond which no other goes on, (F, 2).

    The wall goes on behind a thin wall that stands against it, and with a small step, as at a door that is shut.
    """
    along = (walls.faces[:, 1] - walls.faces[:, 0]) / walls.lengths[:, None]
    beyond = walls.faces + BEYOND * np.stack([-along, along], axis=1)
    near = cKDTree(walls.samples).query_ball_point(beyond, NEAR)
    ends = [not np.any(along[walls.face_of[at]] @ along[f] >= SAME_WAY) for (f, _), at in np.ndenumerate(near)]
    return np.array(ends).reshape(-1, 2)


def _longest_free(pieces: _Pieces) -> float:
    """Length of the longest run of free pieces of one line."""
    longest, length = 0.0, 0.0
    for k in np.flatnonzero(pieces.free):
        follows = k > 0 and pieces.free[k - 1] and pieces.line[k - 1] == pieces.line[k]
        length = pieces.length[k] + (length if follows else 0.0)
        longest = max(longest, length)
    return float(longest)
