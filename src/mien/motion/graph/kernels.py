"""Compiled parts of the fast search (`search` says what they are for and why they are right).

All work on *states*: node ``nodes[i]`` standing at step ``k`` for ``offsets[k] <= i < offsets[k + 1]``; the nodes of a
step rise. ``follows`` and ``recorded`` are of all nodes of the graph: whether a node is the recorded successor of the
one before it, and what going on to it along the recording costs. ``jump`` and ``join`` are weights.
"""

from __future__ import annotations

import numpy as np

from mien.core.compiled import njit

__all__ = ["FAST", "along_the_recording", "apart", "backward_bounds", "beam", "find", "within"]

# mypy: disable-error-code="no-untyped-def"
# (numba infers the types; they stand in the docstrings)

FAST = {"contract", "nsz", "reassoc"}


@njit(cache=True, nogil=True, fastmath=FAST)
def apart(exits, a, entries, b):
    """Root mean square distance of an exit pose and an entry pose, mm."""
    total = np.float32(0)
    for axis in range(exits.shape[1]):
        difference = exits[a, axis] - entries[b, axis]
        total += difference * difference
    return np.sqrt(total)


@njit(cache=True, nogil=True, fastmath=FAST)
def backward_bounds(nodes, offsets, costs, follows, recorded, jump, bounds):
    """Least cost of what comes after each state if joins at jumps were free; fills ``bounds``.

    Parameters
    ----------
    nodes : ndarray of int32, shape (states,)
    offsets : ndarray of int64, shape (steps + 1,)
    costs : ndarray of float64, shape (states,)
        What each state costs on its own, or less.
    follows : ndarray of bool, shape (graph nodes,)
    recorded : ndarray of float32, shape (graph nodes,)
    jump : float
    bounds : ndarray of float64, shape (states,)
    """
    steps = len(offsets) - 1
    for i in range(offsets[steps - 1], offsets[steps]):
        bounds[i] = 0.0
    for step in range(steps - 2, -1, -1):
        least = np.inf
        for j in range(offsets[step + 1], offsets[step + 2]):
            value = costs[j] + bounds[j]
            if value < least:
                least = value
        jumped = least + jump
        j, last = offsets[step + 1], offsets[step + 2]
        for i in range(offsets[step], offsets[step + 1]):
            successor = nodes[i] + 1
            value = jumped
            while j < last and nodes[j] < successor:
                j += 1
            if j < last and nodes[j] == successor and follows[successor]:
                going_on = recorded[successor] + costs[j] + bounds[j]
                if going_on < value:
                    value = going_on
            bounds[i] = value


@njit(cache=True, nogil=True, fastmath=FAST)
def within(nodes, offsets, costs, follows, recorded, jump, bounds, most, kept):
    """Which states a way of cost ``most`` could pass if joins at jumps were free; fills ``kept``.

    Parameters as of `backward_bounds`, with its ``bounds``; ``kept`` is an ndarray of bool, shape (states,).
    """
    steps = len(offsets) - 1
    widest = 0
    for step in range(steps):
        widest = max(widest, offsets[step + 1] - offsets[step])
    before = np.empty(widest)
    here = np.empty(widest)
    least = 0.0
    for step in range(steps):
        now = np.inf
        base = offsets[step - 1] if step else 0
        j, last = base, offsets[step]
        for i in range(offsets[step], offsets[step + 1]):
            value = 0.0
            if step:
                value = least + jump
                node = nodes[i]
                while j < last and nodes[j] < node - 1:
                    j += 1
                if j < last and nodes[j] == node - 1 and follows[node]:
                    going_on = before[j - base] + recorded[node]
                    if going_on < value:
                        value = going_on
            value += costs[i]
            here[i - offsets[step]] = value
            kept[i] = value + bounds[i] <= most
            if value < now:
                now = value
        least = now
        before, here = here, before


@njit(cache=True, nogil=True, fastmath=FAST)
def find(nodes, low, high, node):
    """Place of a node among rising nodes, or -1."""
    end = high
    while low < high:
        middle = (low + high) // 2
        if nodes[middle] < node:
            low = middle + 1
        else:
            high = middle
    return low if low < end and nodes[low] == node else -1


@njit(cache=True, nogil=True, fastmath=FAST)
def _most_promising(values, low, high, room, chosen):
    """Places of the ``room`` least values, in no order; returns how many."""
    heap = np.empty(room)
    count = 0
    for i in range(low, high):
        value = values[i]
        if count == room:
            if value >= heap[0]:
                continue
            place = 0  # the greatest falls out; the new value sinks from the top
            while True:
                child = 2 * place + 1
                if child >= room:
                    break
                if child + 1 < room and heap[child + 1] > heap[child]:
                    child += 1
                if heap[child] <= value:
                    break
                heap[place], chosen[place] = heap[child], chosen[child]
                place = child
        else:
            place = count
            count += 1
            while place and heap[(place - 1) // 2] < value:
                heap[place], chosen[place] = heap[(place - 1) // 2], chosen[(place - 1) // 2]
                place = (place - 1) // 2
        heap[place], chosen[place] = value, i
    return count


@njit(cache=True, nogil=True, fastmath=FAST)
def beam(nodes, offsets, costs, follows, recorded, jump, join, exits, entries, bounds, width, path):
    """A good way, found by keeping a few states a step; fills ``path`` with its states.

    At each step the states that go on from those kept, and those that promise most by ``costs + bounds``, are weighed
    with their joins; the ``width`` best by cost so far and ``bounds`` are kept.
    """
    steps = len(offsets) - 1
    promise = np.empty(len(nodes))
    for i in range(len(nodes)):
        promise[i] = costs[i] + bounds[i]
    kept = np.empty((steps, width), dtype=np.int64)
    origin = np.empty((steps, width), dtype=np.int64)
    reached = np.empty((steps, width))
    counts = np.zeros(steps, dtype=np.int64)
    tried = np.empty(2 * width, dtype=np.int64)
    tried_cost = np.empty(2 * width)
    tried_origin = np.empty(2 * width, dtype=np.int64)
    total = np.empty(2 * width)
    chosen = np.empty(width, dtype=np.int64)
    for step in range(steps):
        low, high = offsets[step], offsets[step + 1]
        count = _most_promising(promise, low, high, width, tried)
        if step:
            for k in range(counts[step - 1]):
                successor = nodes[kept[step - 1, k]] + 1
                if successor < len(follows) and follows[successor]:
                    place = find(nodes, low, high, successor)
                    if place >= 0:
                        tried[count] = place
                        count += 1
        for m in range(count):
            best, best_origin = (0.0, 0) if step == 0 else (np.inf, 0)
            node = nodes[tried[m]]
            if step:
                for k in range(counts[step - 1]):
                    source = nodes[kept[step - 1, k]]
                    if source == node - 1 and follows[node]:
                        value = reached[step - 1, k] + recorded[node]
                    else:
                        value = reached[step - 1, k] + jump + join * apart(exits, source, entries, node)
                    if value < best:
                        best, best_origin = value, k
            tried_cost[m] = best + costs[tried[m]]
            tried_origin[m] = best_origin
            total[m] = tried_cost[m] + bounds[tried[m]]
        for m in range(1, count):  # a state that goes on may be there twice
            for k in range(m):
                if tried[k] == tried[m]:
                    total[m] = np.inf
        counts[step] = _most_promising(total, 0, count, width, chosen)
        for k in range(counts[step]):
            m = chosen[k]
            kept[step, k], origin[step, k], reached[step, k] = tried[m], tried_origin[m], tried_cost[m]
    place = np.argmin(reached[steps - 1, : counts[steps - 1]])
    for step in range(steps - 1, -1, -1):
        path[step] = kept[step, place]
        place = origin[step, place]


@njit(cache=True, nogil=True, fastmath=FAST)
def along_the_recording(step, nodes, offsets, follows, recorded, reached, going_on, going_from):
    """Cost of reaching each state of a step from the node recorded before it; infinite where that is not there."""
    first, after = offsets[step], offsets[step + 1]
    j = offsets[step - 1] if step else 0
    for i in range(first, after):
        going_on[i - first] = np.inf
        going_from[i - first] = -1
        if step:
            node = nodes[i]
            while j < first and nodes[j] < node - 1:
                j += 1
            if j < first and nodes[j] == node - 1 and follows[node]:
                going_on[i - first] = reached[j] + recorded[node]
                going_from[i - first] = j
