"""How far two stretches of audio features lie apart after dynamic time warping (the paper's Eq. 5).

One definition holds everywhere: the symmetric form of Sakoe and Chiba (1978). A path walks through both stretches from
their first frames to their last; a step on in one of them counts the distance of the frames it reaches once, a step on
in both counts it twice, and so does the start. Every path then has the same length, the sum of both frame counts, and
the mean distance along the path of least sum is the least mean as well.

`audio_distance` is the plain reference; `distances_to` is the same, compiled, for many nodes at once, and `hear_all`
goes through an utterance.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.compiled import njit

__all__ = ["audio_distance", "distances_to", "hear_all", "warping_path"]

LANES = 16
"""Nodes that are warped side by side, so that the processor works on all of them with one instruction."""

FEW = 4
"""Fewer nodes than this are warped one by one."""

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]


def audio_distance(heard: NDArray[Any], recorded: NDArray[Any]) -> float:
    """Mean Euclidean distance along the best warping path.

    Parameters
    ----------
    heard, recorded : ndarray, shapes (frames, coefficients) and (other frames, coefficients)

    Examples
    --------
    >>> slow, fast = np.array([[0.0], [0.0], [1.0], [2.0]]), np.array([[0.0], [1.0], [2.0]])
    >>> audio_distance(slow, fast), round(audio_distance(slow, fast + 3.0), 3)
    (0.0, 2.429)
    """
    return float(_sums(heard, recorded)[-1, -1] / (len(heard) + len(recorded)))


def _frame_distances(heard: NDArray[Any], recorded: NDArray[Any]) -> Floats:
    apart = np.asarray(heard, dtype=np.float64)[:, None] - np.asarray(recorded, dtype=np.float64)[None]
    return np.asarray(np.sqrt((apart**2).sum(axis=2)))


def _sums(heard: NDArray[Any], recorded: NDArray[Any]) -> Floats:
    """Least sum of distances of a path up to each pair of frames."""
    distances = _frame_distances(heard, recorded)
    sums = np.full((len(heard), len(recorded)), np.inf)
    for i in range(len(heard)):
        for j in range(len(recorded)):
            best = 2 * distances[0, 0] if i == j == 0 else np.inf
            if i:
                best = min(best, sums[i - 1, j] + distances[i, j])
            if j:
                best = min(best, sums[i, j - 1] + distances[i, j])
            if i and j:
                best = min(best, sums[i - 1, j - 1] + 2 * distances[i, j])
            sums[i, j] = best
    return sums


def warping_path(heard: NDArray[Any], recorded: NDArray[Any]) -> Whole:
    """Pairs of frames that the best warping path brings together, shape (steps, 2), first to last.

    Of steps that cost the same the one on in both stretches is taken.

    Examples
    --------
    >>> warping_path(np.array([[0.0], [0.0], [1.0]]), np.array([[0.0], [1.0]])).tolist()
    [[0, 0], [1, 0], [2, 1]]
    """
    distances, sums = _frame_distances(heard, recorded), _sums(heard, recorded)
    i, j = len(heard) - 1, len(recorded) - 1
    path = [(i, j)]
    while i or j:
        before = [(i - 1, j - 1, 2), (i - 1, j, 1), (i, j - 1, 1)]
        costs = [sums[a, b] + count * distances[i, j] if a >= 0 and b >= 0 else np.inf for a, b, count in before]
        i, j, _ = before[int(np.argmin(costs))]
        path.append((i, j))
    return np.array(path[::-1], dtype=np.int64)


@njit(cache=True, nogil=True, fastmath={"contract", "nsz"})
def _distance_to_one(heard, features, first, count):  # type: ignore[no-untyped-def]
    frames, coefficients = heard.shape
    sums = np.empty(frames, dtype=np.float32)
    for j in range(count):
        diagonal = np.float32(0)
        for i in range(frames):
            apart = np.float32(0)
            for c in range(coefficients):
                difference = heard[i, c] - features[first + j, c]
                apart += difference * difference
            apart = np.sqrt(apart)
            if i == 0 and j == 0:
                sums[0] = 2 * apart
            elif j == 0:
                sums[i] = sums[i - 1] + apart
            elif i == 0:
                diagonal = sums[0]
                sums[0] += apart
            else:
                both = diagonal + 2 * apart
                diagonal = sums[i]
                one = (sums[i - 1] if sums[i - 1] < diagonal else diagonal) + apart
                sums[i] = both if both < one else one
    return sums[frames - 1] / np.float32(frames + count)


@njit(cache=True, nogil=True, fastmath={"contract", "nsz"})
def distances_to(heard, features, starts, counts, nodes, out):  # type: ignore[no-untyped-def]  # numba infers the types
    """Distances of one stretch to those of many nodes (`audio_distance`, compiled, in single precision).

    The value of a node does not depend on which others are asked for with it (but for the last bits, where they are
    fewer than `FEW`).

    Parameters
    ----------
    heard : ndarray of float32, shape (frames, coefficients)
    features : ndarray of float32, shape (all frames, coefficients)
    starts, counts : ndarrays of int
        Rows of `features` that each node of the graph holds.
    nodes : ndarray of int
    out : ndarray of float64, shape (nodes,)
        Is filled.
    """
    frames, coefficients = heard.shape
    asked = len(nodes)
    if asked < FEW:
        for place in range(asked):
            out[place] = _distance_to_one(heard, features, starts[nodes[place]], counts[nodes[place]])
        return
    order = np.argsort(counts[nodes])
    value = np.empty((coefficients, LANES), dtype=np.float32)
    apart = np.empty(LANES, dtype=np.float32)
    diagonal = np.empty(LANES, dtype=np.float32)
    sums = np.empty((frames, LANES), dtype=np.float32)
    first = np.empty(LANES, dtype=np.int64)
    count = np.empty(LANES, dtype=np.int64)
    for block in range(0, asked, LANES):
        for lane in range(LANES):
            node = nodes[order[min(block + lane, asked - 1)]]
            first[lane], count[lane] = starts[node], counts[node]
        for j in range(count[LANES - 1]):
            for lane in range(LANES):
                row = first[lane] + min(j, count[lane] - 1)
                for c in range(coefficients):
                    value[c, lane] = features[row, c]
            for i in range(frames):
                for lane in range(LANES):
                    apart[lane] = 0
                for c in range(coefficients):
                    here = heard[i, c]
                    for lane in range(LANES):
                        difference = here - value[c, lane]
                        apart[lane] += difference * difference
                for lane in range(LANES):
                    apart[lane] = np.sqrt(apart[lane])
                if j == 0 and i == 0:
                    for lane in range(LANES):
                        sums[0, lane] = 2 * apart[lane]
                elif j == 0:
                    for lane in range(LANES):
                        sums[i, lane] = sums[i - 1, lane] + apart[lane]
                elif i == 0:
                    for lane in range(LANES):
                        diagonal[lane] = sums[0, lane]
                        sums[0, lane] += apart[lane]
                else:
                    for lane in range(LANES):
                        both = diagonal[lane] + 2 * apart[lane]
                        diagonal[lane] = sums[i, lane]
                        above, left = sums[i - 1, lane], sums[i, lane]
                        one = (above if above < left else left) + apart[lane]
                        sums[i, lane] = both if both < one else one
            for lane in range(LANES):
                if j == count[lane] - 1 and block + lane < asked:
                    out[order[block + lane]] = sums[frames - 1, lane] / np.float32(frames + count[lane])


@njit(cache=True, nogil=True)
def hear_all(heard, heard_offsets, weights, features, starts, counts, nodes, offsets, costs):  # type: ignore[no-untyped-def]
    """Add weighted distances for the phones of an utterance, one after the other.

    Parameters
    ----------
    heard : ndarray of float32, shape (frames, coefficients)
        Of all phones; those of phone ``k`` are ``heard_offsets[k]`` up to and without ``heard_offsets[k + 1]``.
    heard_offsets : ndarray of int64, shape (phones + 1,)
    weights : ndarray of float64, shape (phones,)
        Phones of weight 0 are not compared.
    features, starts, counts : ndarray
        As of `distances_to`.
    nodes : ndarray of int32, shape (states,)
        Nodes to compare with phone ``k``: ``offsets[k]`` up to and without ``offsets[k + 1]``.
    offsets : ndarray of int64, shape (phones + 1,)
    costs : ndarray of float64, shape (states,)
        Is added to.
    """
    for step in range(len(offsets) - 1):
        first, after = offsets[step], offsets[step + 1]
        if weights[step] > 0 and after > first:
            out = np.empty(after - first)
            rows = heard[heard_offsets[step] : heard_offsets[step + 1]]
            distances_to(rows, features, starts, counts, nodes[first:after], out)
            for place in range(after - first):
                costs[first + place] += weights[step] * out[place]
