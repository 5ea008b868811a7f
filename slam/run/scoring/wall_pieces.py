"""Pieces of mapped lines, each with the true face that it shows; compiled where a loop is long."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled
from slam.lines.segments import IntArray
from slam.pose import FloatArray

PIECE = 0.02  # metres: longest piece of a mapped line that is judged
NEAR = 0.10  # metres: largest distance of a piece from the face that it shows
SAME_WAY = float(np.cos(np.radians(20.0)))  # least cosine between line and face, both with their free side to the left


class Pieces(NamedTuple):
    """P pieces of the mapped lines."""

    line: IntArray
    """(P,): line of each piece, in ascending order."""
    middle: FloatArray
    """(P, 2): middle of each piece."""
    length: FloatArray
    """(P,): length of each piece."""
    span: FloatArray
    """(P, 2): begin and end of each piece along its face, from the start of the face."""
    face: IntArray
    """(P,): nearest face that faces the same way, within NEAR; -1 for none."""
    free: NDArray[np.bool_]
    """(P,): True if no face at all is that near."""


def judge(lines: FloatArray, faces: FloatArray) -> Pieces:
    """Cut the lines (M, 2, 2) into pieces, and find the face (F, 2, 2) that each of them shows."""
    return Pieces(*_judge(lines, faces))


def lengths_once(pieces: Pieces, faces: FloatArray) -> FloatArray:
    """Return the length of each face (F,) on which there are lines, once or several times."""
    on = np.flatnonzero(pieces.face >= 0)
    on = on[np.lexsort([pieces.span[on, 0], pieces.face[on]])]
    return _unions(pieces.face[on], pieces.span[on], len(faces))


@compiled
def _unions(face: IntArray, spans: FloatArray, count: int) -> FloatArray:
    """Return the length of the union of the intervals (Q, 2) of each face, sorted by face and begin, (F,)."""
    lengths, reach, last = np.zeros(count), 0.0, -1
    for q in range(len(face)):
        if face[q] != last:
            last, reach = face[q], spans[q, 0]
        lengths[last] += max(spans[q, 1] - max(spans[q, 0], reach), 0.0)
        reach = max(reach, spans[q, 1])
    return lengths


def longest_free(pieces: Pieces) -> float:
    """Return the length of the longest run of free pieces of one line."""
    longest, length = 0.0, 0.0
    for k in np.flatnonzero(pieces.free):
        follows = k > 0 and pieces.free[k - 1] and pieces.line[k - 1] == pieces.line[k]
        length = pieces.length[k] + (length if follows else 0.0)
        longest = max(longest, length)
    return float(longest)


@compiled
def _judge(
    lines: FloatArray, faces: FloatArray
) -> tuple[IntArray, FloatArray, FloatArray, FloatArray, IntArray, NDArray[np.bool_]]:
    """Compute the columns of Pieces for the lines (M, 2, 2) and faces (F, 2, 2)."""
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
    """Return True if the bounding boxes of two lines (2, 2) are within NEAR in x and in y."""
    for axis in range(2):
        if max(a[0, axis], a[1, axis]) + NEAR < min(b[0, axis], b[1, axis]):
            return False
        if max(b[0, axis], b[1, axis]) + NEAR < min(a[0, axis], a[1, axis]):
            return False
    return True


@compiled
def _distance(x: float, y: float, face: FloatArray) -> float:
    """Return the distance of (x, y) from the face (2, 2), which must have a length."""
    fx, fy = face[1, 0] - face[0, 0], face[1, 1] - face[0, 1]
    px, py = x - face[0, 0], y - face[0, 1]
    along = min(max((px * fx + py * fy) / (fx * fx + fy * fy), 0.0), 1.0)
    return float(np.hypot(px - along * fx, py - along * fy))


@compiled
def _place(x: float, y: float, face: FloatArray) -> float:
    """Return the metres from the start of the face to the projection of (x, y) on its line."""
    fx, fy = face[1, 0] - face[0, 0], face[1, 1] - face[0, 1]
    return float(((x - face[0, 0]) * fx + (y - face[0, 1]) * fy) / np.hypot(fx, fy))


@compiled
def covered(samples: FloatArray, face_of: IntArray, faces: FloatArray, lines: FloatArray) -> NDArray[np.bool_]:
    """Return True for each sample (N, 2) beside a line that faces the same way, within NEAR, (N,)."""
    covered = np.zeros(len(samples), np.bool_)
    directions = faces[:, 1] - faces[:, 0]
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
                fx, fy = directions[face_of[n]]
                covered[n] = fx * dx + fy * dy >= SAME_WAY * np.hypot(fx, fy)
    return covered
