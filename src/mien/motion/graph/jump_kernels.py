"""Compiled parts of the search that deal with jumps: where one may jump from, packed so that little is looked at.

States as in `kernels`.
"""

from __future__ import annotations

import numpy as np

from mien.core.compiled import njit
from mien.motion.graph.kernels import FAST, along_the_recording

__all__ = ["LANES", "blocks_of", "join_bounds", "reach", "room_for_blocks", "widest_step"]

# mypy: disable-error-code="no-untyped-def"
# (numba infers the types; they stand in the docstrings)

LANES = 16
GROUP = 16


@njit(cache=True, nogil=True, fastmath=FAST)
def blocks_of(sources, costs, nodes, exits, order, poses, values, states, low, high, least):
    """Pack the places one may jump from into blocks of like poses; returns how many blocks."""
    count = len(sources)
    place = np.empty(count, dtype=np.int64)
    for k in range(count):
        place[k] = order[nodes[sources[k]]]
    ranked = np.argsort(place)
    blocks = (count + LANES - 1) // LANES
    for block in range(blocks):
        least[block] = np.inf
        for lane in range(LANES):
            k = ranked[min(block * LANES + lane, count - 1)]
            state = sources[k]
            states[block, lane] = state
            values[block, lane] = costs[state]
            least[block] = min(least[block], costs[state])
            for axis in range(exits.shape[1]):
                value = exits[nodes[state], axis]
                poses[block, axis, lane] = value
                if lane == 0 or value < low[axis, block]:
                    low[axis, block] = value
                if lane == 0 or value > high[axis, block]:
                    high[axis, block] = value
    for block in range(blocks):  # boxes of groups of blocks stand behind those of the blocks
        group = blocks + block // GROUP
        if block % GROUP == 0:
            least[group] = np.inf
        least[group] = min(least[group], least[block])
        for axis in range(exits.shape[1]):
            if block % GROUP == 0 or low[axis, block] < low[axis, group]:
                low[axis, group] = low[axis, block]
            if block % GROUP == 0 or high[axis, block] > high[axis, group]:
                high[axis, group] = high[axis, block]
    return blocks


@njit(cache=True, nogil=True, fastmath=FAST)
def reach(node, entries, jump, join, blocks, poses, values, states, low, high, least, bound, best, origin):
    """Least cost of reaching a node by a jump, if less than ``best``; and from which state."""
    axes = entries.shape[1]
    groups = (blocks + GROUP - 1) // GROUP
    _bound_boxes(node, entries, jump, join, blocks, blocks + groups, low, high, least, bound)
    nearest = np.argmin(bound[blocks : blocks + groups])
    apart = np.empty(LANES, dtype=np.float32)
    for turn in range(-1, groups):
        group = nearest if turn < 0 else turn
        if bound[blocks + group] > best or turn == nearest:
            continue
        first, after = group * GROUP, min((group + 1) * GROUP, blocks)
        _bound_boxes(node, entries, jump, join, first, after, low, high, least, bound)
        for block in range(first, after):
            if bound[block] > best:
                continue
            for lane in range(LANES):
                apart[lane] = 0.0
            for axis in range(axes):
                here = entries[node, axis]
                for lane in range(LANES):
                    difference = poses[block, axis, lane] - here
                    apart[lane] += difference * difference
            for lane in range(LANES):
                value = values[block, lane] + jump + join * np.sqrt(apart[lane])
                if value < best:
                    best, origin = value, states[block, lane]
    return best, origin


@njit(cache=True, nogil=True, fastmath=FAST)
def _bound_boxes(node, entries, jump, join, first, after, low, high, least, bound):
    """Fill ``bound`` with what a jump to a node costs at least from boxes ``first`` up to and without ``after``."""
    for box in range(first, after):
        bound[box] = 0.0
    for axis in range(entries.shape[1]):
        here = entries[node, axis]
        for box in range(first, after):
            below, above = low[axis, box] - here, here - high[axis, box]
            outside = max(max(below, above), np.float32(0))
            bound[box] += outside * outside
    for box in range(first, after):
        bound[box] = least[box] + jump + join * np.sqrt(bound[box])


@njit(cache=True, nogil=True, fastmath=FAST)
def widest_step(offsets):
    """The most states that a step has."""
    widest = 0
    for step in range(len(offsets) - 1):
        widest = max(widest, offsets[step + 1] - offsets[step])
    return widest


@njit(cache=True, nogil=True, fastmath=FAST)
def room_for_blocks(widest, axes):
    """Empty arrays for `blocks_of` and `reach`: poses, values, states, low, high, least, bound."""
    room = (widest + LANES - 1) // LANES
    boxes = room + room // GROUP + 1
    return (
        np.empty((room, axes, LANES), dtype=np.float32),
        np.empty((room, LANES)),
        np.empty((room, LANES), dtype=np.int32),
        np.empty((axes, boxes), dtype=np.float32),
        np.empty((axes, boxes), dtype=np.float32),
        np.empty(boxes),
        np.empty(boxes),
    )


@njit(cache=True, nogil=True, fastmath=FAST)
def join_bounds(
    nodes, offsets, costs, follows, recorded, jump, join, exits, entries, order, bounds, most, before, after
):
    """Least cost up to and with each state, and of what comes after it, joins included; fills ``before``, ``after``.

    Parameters as of `cheapest_way`; both results are ndarrays of float64, shape (states,). They are infinite for states
    that no way of cost ``most`` passes.
    """
    steps = len(offsets) - 1
    widest = widest_step(offsets)
    going_on = np.empty(widest)
    going_from = np.empty(widest, dtype=np.int32)
    poses, values, block_states, low, high, least_of, bound = room_for_blocks(widest, exits.shape[1])
    least = 0.0
    for step in range(steps):
        first, last = offsets[step], offsets[step + 1]
        blocks = 0
        if step:
            sources = offsets[step - 1] + np.flatnonzero(before[offsets[step - 1] : first] < np.inf)
            blocks = blocks_of(sources, before, nodes, exits, order, poses, values, block_states, low, high, least_of)
        along_the_recording(step, nodes, offsets, follows, recorded, before, going_on, going_from)
        for i in range(first, last):
            value = 0.0 if step == 0 else min(going_on[i - first], least + jump)
            if value + costs[i] + bounds[i] > most:
                before[i] = np.inf
                continue
            if step:
                value, _ = reach(nodes[i], entries, jump, join, blocks, poses, values, block_states, low, high,
                                  least_of, bound, going_on[i - first], -1)  # fmt: skip
            before[i] = value + costs[i]
            if before[i] + bounds[i] > most:
                before[i] = np.inf
        least = before[first:last].min()
    whole = np.empty(len(nodes))
    for step in range(steps - 1, -1, -1):
        first, last = offsets[step], offsets[step + 1]
        blocks, j, end = 0, last, last
        if step < steps - 1:
            end = offsets[step + 2]
            sources = last + np.flatnonzero(whole[last:end] < np.inf)
            blocks = blocks_of(sources, whole, nodes, entries, order, poses, values, block_states, low, high, least_of)
        for i in range(first, last):
            after[i] = whole[i] = np.inf
            if before[i] == np.inf:
                continue
            value = 0.0
            if step < steps - 1:
                value, successor = np.inf, nodes[i] + 1
                while j < end and nodes[j] < successor:
                    j += 1
                if j < end and nodes[j] == successor and follows[successor]:
                    value = whole[j] + recorded[successor]
                value, _ = reach(nodes[i], exits, jump, join, blocks, poses, values, block_states, low, high,
                                  least_of, bound, value, -1)  # fmt: skip
            if before[i] + value <= most:
                after[i], whole[i] = value, value + costs[i]
