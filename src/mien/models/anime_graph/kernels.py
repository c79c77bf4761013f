"""Compiled parts of the fast search (`search` says what they are for and why they are right).

All work on *states*: node ``nodes[i]`` standing at step ``k`` for ``offsets[k] <= i < offsets[k + 1]``; the nodes of a
step rise. ``follows`` and ``recorded`` are of all nodes of the graph: whether a node is the recorded successor of the
one before it, and what going on to it along the recording costs. ``jump`` and ``join`` are weights.
"""

from __future__ import annotations

import numpy as np
from numba import njit

__all__ = ["backward_bounds", "beam", "cheapest_way", "join_bounds", "within"]

# mypy: disable-error-code="no-untyped-def"
# (numba infers the types; they stand in the docstrings)

LANES = 16
GROUP = 16

_FAST = {"contract", "nsz", "reassoc"}


@njit(cache=True, nogil=True, fastmath=_FAST)
def _apart(exits, a, entries, b):
    """Root mean square distance of an exit pose and an entry pose, mm."""
    total = np.float32(0)
    for axis in range(exits.shape[1]):
        difference = exits[a, axis] - entries[b, axis]
        total += difference * difference
    return np.sqrt(total)


@njit(cache=True, nogil=True, fastmath=_FAST)
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


@njit(cache=True, nogil=True, fastmath=_FAST)
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


@njit(cache=True, nogil=True, fastmath=_FAST)
def _find(nodes, low, high, node):
    """Place of a node among rising nodes, or -1."""
    end = high
    while low < high:
        middle = (low + high) // 2
        if nodes[middle] < node:
            low = middle + 1
        else:
            high = middle
    return low if low < end and nodes[low] == node else -1


@njit(cache=True, nogil=True, fastmath=_FAST)
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


@njit(cache=True, nogil=True, fastmath=_FAST)
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
                    place = _find(nodes, low, high, successor)
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
                        value = reached[step - 1, k] + jump + join * _apart(exits, source, entries, node)
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


@njit(cache=True, nogil=True, fastmath=_FAST)
def _blocks(sources, costs, nodes, exits, order, poses, values, states, low, high, least):
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


@njit(cache=True, nogil=True, fastmath=_FAST)
def _reach(node, entries, jump, join, blocks, poses, values, states, low, high, least, bound, best, origin):
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


@njit(cache=True, nogil=True, fastmath=_FAST)
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


@njit(cache=True, nogil=True, fastmath=_FAST)
def join_bounds(
    nodes, offsets, costs, follows, recorded, jump, join, exits, entries, order, bounds, most, before, after
):
    """Least cost up to and with each state, and of what comes after it, joins included; fills ``before``, ``after``.

    Parameters as of `cheapest_way`; both results are ndarrays of float64, shape (states,). They are infinite for states
    that no way of cost ``most`` passes.
    """
    steps = len(offsets) - 1
    axes = exits.shape[1]
    widest = 0
    for step in range(steps):
        widest = max(widest, offsets[step + 1] - offsets[step])
    going_on = np.empty(widest)
    going_from = np.empty(widest, dtype=np.int32)
    room = (widest + LANES - 1) // LANES
    poses = np.empty((room, axes, LANES), dtype=np.float32)
    values = np.empty((room, LANES))
    block_states = np.empty((room, LANES), dtype=np.int32)
    boxes = room + room // GROUP + 1
    low, high = np.empty((axes, boxes), dtype=np.float32), np.empty((axes, boxes), dtype=np.float32)
    least_of, bound = np.empty(boxes), np.empty(boxes)
    least = 0.0
    for step in range(steps):
        first, last = offsets[step], offsets[step + 1]
        blocks = 0
        if step:
            sources = offsets[step - 1] + np.flatnonzero(before[offsets[step - 1] : first] < np.inf)
            blocks = _blocks(sources, before, nodes, exits, order, poses, values, block_states, low, high, least_of)
        _along_the_recording(step, nodes, offsets, follows, recorded, before, going_on, going_from)
        for i in range(first, last):
            value = 0.0 if step == 0 else min(going_on[i - first], least + jump)
            if value + costs[i] + bounds[i] > most:
                before[i] = np.inf
                continue
            if step:
                value, _ = _reach(nodes[i], entries, jump, join, blocks, poses, values, block_states, low, high,
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
            blocks = _blocks(sources, whole, nodes, entries, order, poses, values, block_states, low, high, least_of)
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
                value, _ = _reach(nodes[i], exits, jump, join, blocks, poses, values, block_states, low, high,
                                  least_of, bound, value, -1)  # fmt: skip
            if before[i] + value <= most:
                after[i], whole[i] = value, value + costs[i]


@njit(cache=True, nogil=True, fastmath=_FAST)
def cheapest_way(nodes, offsets, costs, follows, recorded, jump, join, exits, entries, order, bounds, most, path):
    """The cheapest way; fills ``path`` with its states and returns its cost, and how many states were weighed.

    Parameters as of `beam`; ``order`` is `GraphIndex.exit_order`, ``most`` the cost of a known way (and a little more).
    The cost is infinite if no way is within ``most``.
    """
    steps = len(offsets) - 1
    states = len(nodes)
    axes = exits.shape[1]
    widest = 0
    for step in range(steps):
        widest = max(widest, offsets[step + 1] - offsets[step])
    reached = np.full(states, np.inf)  # least cost up to and with a state, where it can matter
    origin = np.full(states, -1, dtype=np.int32)
    going_on = np.empty(widest)
    going_from = np.empty(widest, dtype=np.int32)
    lowest = np.empty(widest)
    room = (widest + LANES - 1) // LANES
    poses = np.empty((room, axes, LANES), dtype=np.float32)
    values = np.empty((room, LANES))
    block_states = np.empty((room, LANES), dtype=np.int32)
    boxes = room + room // GROUP + 1
    low, high = np.empty((axes, boxes), dtype=np.float32), np.empty((axes, boxes), dtype=np.float32)
    least_of, bound = np.empty(boxes), np.empty(boxes)
    rival_poses = np.empty((room, axes, LANES), dtype=np.float32)
    rival_values = np.empty((room, LANES), dtype=np.float32)
    rival_least = np.empty(room)
    sources = np.empty(widest, dtype=np.int32)
    blocks, least, weighed, end = 0, 0.0, 0, -1
    for step in range(steps):
        first, after = offsets[step], offsets[step + 1]
        _along_the_recording(step, nodes, offsets, follows, recorded, reached, going_on, going_from)
        for i in range(first, after):
            here = going_on[i - first] if step else 0.0
            if step and least + jump < here:
                here = least + jump
            lowest[i - first] = here + costs[i]
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
                value, source = _reach(node, entries, jump, join, blocks, poses, values, block_states, low, high,
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
            blocks = _blocks(
                sources[:count], reached, nodes, exits, order, poses, values, block_states, low, high, least_of
            )
    for step in range(steps - 1, -1, -1):
        path[step] = end
        end = origin[end]
    return least, weighed


@njit(cache=True, nogil=True, fastmath=_FAST)
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


@njit(cache=True, nogil=True, fastmath=_FAST)
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


@njit(cache=True, nogil=True, fastmath=_FAST)
def _along_the_recording(step, nodes, offsets, follows, recorded, reached, going_on, going_from):
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


@njit(cache=True, nogil=True, fastmath=_FAST)
def _rival_goes_on(node, rival, cost, step, nodes, offsets, follows, recorded, reached, exits, entries, jump, join):
    """Whether the rival's jump to the node's recorded successor is as cheap as going on, or there is no going on."""
    if step == len(offsets) - 2:
        return True
    successor = node + 1
    if successor >= len(follows) or not follows[successor]:
        return True
    if _find(nodes, offsets[step + 1], offsets[step + 2], successor) < 0:
        return True
    jumped = reached[rival] + jump + join * _apart(exits, nodes[rival], entries, successor)
    return jumped <= cost + recorded[successor]
