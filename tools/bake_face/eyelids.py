"""Eyelids: they meet when they close, and they keep clear of the eyeball on the way."""

from __future__ import annotations

import numpy as np
from contact import Edges, edges_between
from head import Head
from makehuman import Floats, Ints

_OVERLAP = -0.9  # mm: shut lids pass each other by this much, so that no light shows between them
_CORNER_OVERLAP = -0.9  # mm more towards the corners of the eye
_AIR = 0.25  # mm between a lid and the eyeball
_MARGIN_RING = 4  # the lid's edge lies this many rows of vertices outside the border of the eye's hole
# Shapes in which something near the eye moves.
_MOVING = ("eyeBlink", "eyeSquint", "eyeWide", "eyeLookUp", "eyeLookDown", "eyeLookIn", "eyeLookOut", "cheekSquint")
# Lids follow the gaze farther than in MakeHuman's shapes: some of another shape is added.
_FOLLOWING = {"eyeLookUp": ("eyeWide", 0.30), "eyeLookDown": ("eyeBlink", 0.17)}
# A face at rest is not startled: the upper lid covers the iris's upper edge. This share of the way to shut.
_AT_REST = 0.13
_STEPS = np.linspace(0.1, 1.0, 10)


def rows_around(triangles: Ints, hole: Ints, count: int, n: int) -> Ints:
    """How many rows of vertices lie between each vertex and the hole's border; -1 beyond ``count``."""
    row = np.full(n, -1)
    row[hole] = 0
    for step in range(1, count + 1):
        beside = triangles[(row[triangles] == step - 1).any(axis=1)].ravel()
        beside = beside[row[beside] < 0]
        row[beside] = step
    return row


def lid_loops(head: Head) -> list[Ints]:
    """The edge of the left and of the right eye's lids, in order around the eye."""
    skin = head.skin
    loops = []
    for hole, centre in zip(head.eye_holes, head.eye_centres, strict=True):
        row = rows_around(skin.triangles, hole, _MARGIN_RING, len(skin.vertices))
        margin = np.flatnonzero(row == _MARGIN_RING)
        turn = np.arctan2(*(skin.vertices[margin] - centre)[:, [1, 0]].T)
        loops.append(margin[np.argsort(turn)])
    return loops


def fit_lids(head: Head, eye_radius: float) -> list[Edges]:
    """Correct rest and shapes of both eyes' lids; returns the lids as edges that meet."""
    skin = head.skin
    edges = []
    for side, hole, loop, centre in zip(
        ("Left", "Right"), head.eye_holes, lid_loops(head), head.eye_centres, strict=True
    ):
        lids = edges_between(skin.vertices, skin.triangles, loop, reach=1.6, pull=6.0, columns=False)
        lids.upper_pull *= 2
        lids.lower_pull *= 0
        row = rows_around(skin.triangles, hole, 14, len(skin.vertices))
        outside = np.flatnonzero(row >= _MARGIN_RING - 1)
        skin.vertices[outside] += _pushed_out(skin.vertices[outside], centre, eye_radius + _AIR)
        blink = "eyeBlink" + side
        skin.shapes[blink] = skin.shapes[blink] + lids.closing(skin.posed(**{blink: 1.0}), _OVERLAP, _CORNER_OVERLAP)
        skin.vertices += _AT_REST * skin.shapes[blink]
        skin.shapes[blink] = (1 - _AT_REST) * skin.shapes[blink]
        for name, (other, share) in _FOLLOWING.items():
            skin.shapes[name + side] = skin.shapes[name + side] + share * skin.shapes[other + side]
        _clear(head, side, outside, centre, eye_radius)
        edges.append(lids)
    return edges


def close_lids(head: Head, edges: list[Edges], eye_radius: float) -> None:
    """Make blinks shut and lids clear the eyeballs again, after shapes were changed; ``edges`` as `fit_lids` gave."""
    skin = head.skin
    for side, hole, lids, centre in zip(("Left", "Right"), head.eye_holes, edges, head.eye_centres, strict=True):
        blink = "eyeBlink" + side
        skin.shapes[blink] = skin.shapes[blink] + lids.closing(skin.posed(**{blink: 1.0}), _OVERLAP, _CORNER_OVERLAP)
        row = rows_around(skin.triangles, hole, 14, len(skin.vertices))
        _clear(head, side, np.flatnonzero(row >= _MARGIN_RING - 1), centre, eye_radius)


def _clear(head: Head, side: str, outside: Ints, centre: Floats, eye_radius: float) -> None:
    skin = head.skin
    for name in (kind + side for kind in _MOVING):
        skin.shapes[name][outside] += _clearance(skin.vertices, skin.shapes[name], outside, centre, eye_radius)


def _pushed_out(points: Floats, centre: Floats, radius: float) -> Floats:
    arm = points - centre
    distance = np.linalg.norm(arm, axis=1, keepdims=True)
    return np.asarray(arm / distance * np.maximum(radius - distance, 0))


def _clearance(rest: Floats, offsets: Floats, chosen: Ints, centre: Floats, radius: float) -> Floats:
    """What to add to a shape so that the chosen vertices stay outside the eyeball at every weight."""
    added = np.zeros((len(chosen), 3))
    moving = (np.abs(offsets[chosen]).max(axis=1) > 1e-9)[:, None]
    for _ in range(3):
        for weight in _STEPS:
            points = rest[chosen] + weight * (offsets[chosen] + added)
            added += moving * _pushed_out(points, centre, radius + _AIR * 0.8) / weight
    return added
