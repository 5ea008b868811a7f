"""Covariances of the poses of a graph: the diagonal blocks of the inverse of its information matrix.

The inverse is full, but its blocks at the non-zero blocks of the factors L D L^T follow from one another, from the last
column backwards (Takahashi, Fagan and Chen, 1973; Kaess and Dellaert, Robotics and Autonomous Systems 57, 2009): Z_ij =
-sum_k Z_ik L_kj and Z_jj = D_j^-1 - sum_k L_kj^T Z_kj, over the blocks k of column j of L.
"""

from typing import TYPE_CHECKING

import numpy as np

from slam.compiled import compiled, compiled_on_views
from slam.graph.pose_graph import Edges, linear_system
from slam.lines.segments import IntArray
from slam.pose import FloatArray
from slam.small_matrices import add, inverse, product, subtract_product, write

if TYPE_CHECKING:  # scipy loads slowly
    from scipy.sparse import csc_matrix


def pose_covariances(poses: FloatArray, edges: Edges, weights: FloatArray) -> FloatArray:
    """Return the covariances (N, 3, 3) of poses (N, 3), map frame, with the first known.

    ``weights`` (E,) are those of the edges.
    """
    covariances = np.zeros((len(poses), 3, 3))
    if len(poses) > 1:
        H, _ = linear_system(poses, edges, weights)
        covariances[1:] = inverse_blocks(H[3:, 3:])
    return covariances


def inverse_blocks(H: "csc_matrix") -> FloatArray:
    """Return the diagonal blocks (N, 3, 3) of the inverse of a symmetric positive definite (3N, 3N)."""
    blocks = H.tobsr(blocksize=(3, 3))
    blocks.sort_indices()
    begins, rows = blocks.indptr.astype(np.int64), blocks.indices.astype(np.int64)
    place = _elimination_places(begins, rows)
    columns, members = _pattern(begins, rows, place)
    D, L = _factors(begins, rows, blocks.data, place, columns, members)
    return np.asarray(_inverse_diagonal(D, L, columns, members)[place])


def _elimination_places(begins: IntArray, rows: IntArray) -> IntArray:
    """Return the place of each node in the order of elimination, (N,), with few fill-in blocks: minimum degree."""
    from scipy.sparse import csc_matrix, identity
    from scipy.sparse.linalg import splu

    count = len(begins) - 1
    graph = csc_matrix((np.ones(len(rows)), rows, begins), shape=(count, count)) + count * identity(count, format="csc")
    factors = splu(graph, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    return np.asarray(factors.perm_c, np.int64)


@compiled
def _pattern(begins: IntArray, rows: IntArray, place: IntArray) -> tuple[IntArray, IntArray]:
    """Return the beginnings of L's columns, (N + 1,), and the ascending rows of their blocks, in order of elimination.

    A column has the blocks of the matrix below its diagonal, and those that its children in the elimination tree have
    below theirs.
    """
    count = len(place)
    node = _node_at(place)
    first_child, next_child = np.full(count, -1, np.int64), np.full(count, -1, np.int64)
    mark = np.full(count, -1, np.int64)
    columns, members, size = np.zeros(count + 1, np.int64), np.empty(len(rows), np.int64), 0
    for j in range(count):
        while size + count - j > len(members):
            members = np.concatenate((members, np.empty(len(members) + count, np.int64)))
        mark[j] = j
        for i in range(begins[node[j]], begins[node[j] + 1]):
            size = _note(place[rows[i]], j, mark, members, size)
        child = first_child[j]
        while child >= 0:
            for i in range(columns[child], columns[child + 1]):
                size = _note(members[i], j, mark, members, size)
            child = next_child[child]
        columns[j + 1] = size
        _sort(members, columns[j], size)
        if size > columns[j]:
            parent = members[columns[j]]
            next_child[j], first_child[parent] = first_child[parent], j
    return columns, members[:size].copy()


@compiled
def _sort(numbers: IntArray, begin: int, end: int) -> None:
    """Sort a few of these numbers in place, most of which ascend already."""
    for k in range(begin + 1, end):
        number, at = numbers[k], k
        while at > begin and numbers[at - 1] > number:
            numbers[at] = numbers[at - 1]
            at -= 1
        numbers[at] = number


@compiled
def _node_at(place: IntArray) -> IntArray:
    """Return the node at each place: the inverse of a permutation."""
    node = np.empty(len(place), np.int64)
    for k in range(len(place)):
        node[place[k]] = k
    return node


@compiled_on_views
def _note(i: int, j: int, mark: IntArray, members: IntArray, size: int) -> int:
    """Write row ``i`` of column ``j``, if it is below the diagonal and new; return the new size."""
    if i > j and mark[i] != j:
        mark[i], members[size] = j, i
        return size + 1
    return size


@compiled
def _factors(
    begins: IntArray, rows: IntArray, data: FloatArray, place: IntArray, columns: IntArray, members: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Return the inverse of D (N, 3, 3), and the blocks of L, (B, 3, 3)."""
    count = len(place)
    node, at = _node_at(place), np.zeros(count, np.int64)
    D, L = np.zeros((count, 3, 3)), np.zeros((len(members), 3, 3))
    for j in range(count):
        for b in range(columns[j], columns[j + 1]):
            at[members[b]] = b
        for b in range(begins[node[j]], begins[node[j] + 1]):
            i = place[rows[b]]
            if i == j:
                add(D[j], data[b])
            elif i > j:  # the blocks of a row are those of the column, transposed
                add(L[at[i]], data[b].T)
    for j in range(count):
        write(D[j], inverse(D[j]))
        for b in range(columns[j], columns[j + 1]):
            k = members[b]
            for i in range(columns[k], columns[k + 1]):
                at[members[i]] = i
            update = product(L[b], D[j])
            subtract_product(D[k], update, L[b].T)
            for i in range(b + 1, columns[j + 1]):
                subtract_product(L[at[members[i]]], L[i], update.T)
        for b in range(columns[j], columns[j + 1]):
            write(L[b], product(L[b], D[j]))
    return D, L


@compiled
def _inverse_diagonal(D: FloatArray, L: FloatArray, columns: IntArray, members: IntArray) -> FloatArray:
    """Return the blocks Z_jj (N, 3, 3) of the inverse, in the order of elimination; ``D`` (N, 3, 3) is inverted."""
    diagonal, below = np.zeros(D.shape), np.zeros(L.shape)
    at = np.zeros(len(D), np.int64)
    for j in range(len(D) - 1, -1, -1):
        begin, end = columns[j], columns[j + 1]
        for b in range(begin, end):
            at[members[b]] = b
        for b in range(begin, end):
            k = members[b]
            subtract_product(below[b], diagonal[k], L[b])
            for i in range(columns[k], columns[k + 1]):
                c = at[members[i]]
                if begin <= c < end and members[c] == members[i]:
                    subtract_product(below[c], below[i], L[b])
                    subtract_product(below[b], below[i].T, L[c])
        write(diagonal[j], D[j])
        for b in range(begin, end):
            subtract_product(diagonal[j], L[b].T, below[b])
    return diagonal
