"""The compiled heart of the fast search: the cheapest way through all states that can matter.

States as in `kernels`.
"""

from __future__ import annotations

import numpy as np

from mien.core.compiled import njit
from mien.motion.graph.jump_kernels import LANES, blocks_of, reach, room_for_blocks, widest_step
from mien.motion.graph.kernels import FAST, along_the_recording, apart, find

__all__ = ["cheapest_way"]

# mypy: disable-error-code="no-untyped-def"
# (numba infers the types; they stand in the docstrings)


@njit(cache=True, nogil=True, fastmath=FAST)
def cheapest_way(nodes, offsets, costs, follows, recorded, jump, join, exits, entries, order, bounds, most, path):
    """The cheapest way; fills ``path`` with its states and returns its cost, and how many states were weighed.

    Parameters as of `beam`; ``order`` is `GraphIndex.exit_order`, ``most`` the cost of a known way (and a little more).
    The cost is infinite if no way is within ``most``.
    """
    steps = len(offsets) - 1
    states = len(nodes)
    axes = exits.shape[1]
    widest = widest_step(offsets)
    reached = np.full(states, np.inf)  # least cost up to and with a state, where it can matter
    origin = np.full(states, -1, dtype=np.int32)
    going_on = np.empty(widest)
    going_from = np.empty(widest, dtype=np.int32)
    lowest = np.empty(widest)
    poses, values, block_states, low, high, least_of, bound = room_for_blocks(widest, axes)
    rival_poses, rival_values, rival_least = _room_for_rivals(widest, axes)
    sources = np.empty(widest, dtype=np.int32)
    blocks, least, weighed, end = 0, 0.0, 0, -1
    for step in range(steps):
        first, after = offsets[step], offsets[step + 1]
        along_the_recording(step, nodes, offsets, follows, recorded, reached, going_on, going_from)
        _fill_lowest(step, first, after, going_on, least + jump, costs, lowest)
        count, now = 0, np.inf
        for k in np.argsort(lowest[: after - first]):
            i = first + k
            if lowest[k] + bounds[i] > most:
                continue
            if step == steps - 1 and lowest[k] >= now:
                break
            node = nodes[i]
            rival = _rival(node, lowest[k], join, count, sources, exits, rival_poses, rival_values, rival_least)
            if rival >= 0 and _rival_goes_on(node, rival, lowest[k], step, nodes, offsets, follows, recorded, reached,
                                             exits, entries, jump, join):  # fmt: skip
                continue
            value, source = (0.0, -1) if step == 0 else (going_on[k], going_from[k])
            if step:
                value, source = reach(node, entries, jump, join, blocks, poses, values, block_states, low, high,
                                       least_of, bound, value, source)  # fmt: skip
            value += costs[i]
            weighed += 1
            reached[i], origin[i] = value, source
            if value < now:
                now, end = value, i
            if (
                rival < 0
                and _rival(node, value, join, count, sources, exits, rival_poses, rival_values, rival_least) < 0
            ):
                _add_rival(i, node, value, count, sources, exits, rival_poses, rival_values, rival_least)
                count += 1
        if count == 0:
            return np.inf, weighed
        least = now
        if step < steps - 1:
            blocks = blocks_of(
                sources[:count], reached, nodes, exits, order, poses, values, block_states, low, high, least_of
            )
    _trace(end, origin, path)
    return least, weighed


@njit(cache=True, nogil=True, fastmath=FAST)
def _fill_lowest(step, first, after, going_on, by_a_jump, costs, lowest):
    """Least cost up to and with each state of a step, as if joins cost nothing."""
    for i in range(first, after):
        here = going_on[i - first] if step else 0.0
        if step and by_a_jump < here:
            here = by_a_jump
        lowest[i - first] = here + costs[i]


@njit(cache=True, nogil=True, fastmath=FAST)
def _room_for_rivals(widest, axes):
    """Empty arrays for `_add_rival`: poses, values, least."""
    room = (widest + LANES - 1) // LANES
    return (
        np.empty((room, axes, LANES), dtype=np.float32),
        np.empty((room, LANES), dtype=np.float32),
        np.empty(room),
    )


@njit(cache=True, nogil=True, fastmath=FAST)
def _trace(end, origin, path):
    """Fill ``path`` with the states that lead to ``end``."""
    for step in range(len(path) - 1, -1, -1):
        path[step] = end
        end = origin[end]


@njit(cache=True, nogil=True, fastmath=FAST)
def _add_rival(state, node, value, count, sources, exits, rival_poses, rival_values, rival_least):
    block, lane = count // LANES, count % LANES
    if lane == 0:
        rival_least[block] = np.inf
        for other in range(LANES):
            rival_values[block, other] = np.inf
            for axis in range(exits.shape[1]):
                rival_poses[block, axis, other] = 0.0
    sources[count] = state
    # Rounded up: a rival must not look better than it is.
    rival_values[block, lane] = np.float32(value + abs(value) * 1e-7)
    rival_least[block] = min(rival_least[block], value)
    for axis in range(exits.shape[1]):
        rival_poses[block, axis, lane] = exits[node, axis]


@njit(cache=True, nogil=True, fastmath=FAST)
def _rival(node, cost, join, count, sources, exits, rival_poses, rival_values, rival_least):
    """A state from which every jump is at least as cheap as from a node reached at ``cost``; -1 if there is none."""
    apart = np.empty(LANES, dtype=np.float32)
    scale = np.float32(join)
    for block in range((count + LANES - 1) // LANES):
        if rival_least[block] > cost:
            continue
        for lane in range(LANES):
            apart[lane] = 0.0
        for axis in range(exits.shape[1]):
            here = exits[node, axis]
            for lane in range(LANES):
                difference = rival_poses[block, axis, lane] - here
                apart[lane] += difference * difference
        for lane in range(LANES):
            apart[lane] = rival_values[block, lane] + scale * np.sqrt(apart[lane])
        found = -1
        for lane in range(LANES):
            if apart[lane] <= cost:
                found = lane
        if found >= 0:
            return sources[block * LANES + found]
    return -1


@njit(cache=True, nogil=True, fastmath=FAST)
def _rival_goes_on(node, rival, cost, step, nodes, offsets, follows, recorded, reached, exits, entries, jump, join):
    """Whether the rival's jump to the node's recorded successor is as cheap as going on, or there is no going on."""
    if step == len(offsets) - 2:
        return True
    successor = node + 1
    if successor >= len(follows) or not follows[successor]:
        return True
    if find(nodes, offsets[step + 1], offsets[step + 2], successor) < 0:
        return True
    jumped = reached[rival] + jump + join * apart(exits, nodes[rival], entries, successor)
    return jumped <= cost + recorded[successor]
