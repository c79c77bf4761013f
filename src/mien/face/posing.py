"""Posing a face: from channel values to vertices and normals.

The steps, in order:

1. every part's sparse targets are added, weighed by their channels;
2. eyeballs turn rigidly about their centres (`eye_rotation`);
3. the head turns about its pivot (`head_rotation`), each vertex by its ``head_weight``: positions run on the straight
   line between the unturned and the turned place (eyeballs go with the head in full);
4. normals are the area-weighted mean of the triangles around a vertex. Vertices that lie and move together (the two
   sides of a seam in the texture) share one normal.

`Poser` runs compiled loops; `pose_reference` says the same in plain numpy and is the referee of the tests. The loops
make normals only where targets or the neck bend the surface: elsewhere (the back of the head, hair, eyes, trunk) those
of the face at rest are turned along.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mien.core.channels import ALL
from mien.core.compiled import njit
from mien.core.errors import InputError, unknown_name
from mien.face.model import Eye, Face, Part
from mien.face.normals import Rings, ring_normals, rings_of

__all__ = ["PosedFace", "PosedPart", "Poser", "eye_rotation", "head_rotation", "pose_reference", "welded_vertices"]

Floats = NDArray[np.float32]
Indices = NDArray[np.int32]
Matrix = NDArray[np.float64]

# Vertices closer than this (mm), at rest and in a mixture of all targets, are one point of the surface.
_WELD_MM = 1e-3
_UNTURNED, _APART = -1, -2  # beside the numbers of turns
_BLOCK = 16  # vertices that are posed together


def head_rotation(yaw: float, pitch: float, roll: float) -> Matrix:
    """Rotation of the head from its three angles.

    Parameters
    ----------
    yaw, pitch, roll : float
        Degrees; positive turns to the speaker's left, looks up, tips to the speaker's left shoulder. Intrinsic, in
        this order (`mien.core.channels`).

    Returns
    -------
    ndarray of float64, shape (3, 3)
        Turns column vectors: ``turned = matrix @ vector``.

    Examples
    --------
    >>> (head_rotation(90, 0, 0) @ [0, 0, 1]).round(6).tolist()
    [1.0, 0.0, 0.0]
    """
    y, p, r = math.radians(yaw), -math.radians(pitch), -math.radians(roll)
    sy, cy, sp, cp, sr, cr = math.sin(y), math.cos(y), math.sin(p), math.cos(p), math.sin(r), math.cos(r)
    return np.array(  # about y, then x, then z
        [
            [cy * cr + sy * sp * sr, sy * sp * cr - cy * sr, sy * cp],
            [cp * sr, cp * cr, -sp],
            [cy * sp * sr - sy * cr, sy * sr + cy * sp * cr, cy * cp],
        ]
    )


def eye_rotation(eye: Eye, up: float, down: float, inward: float, outward: float) -> Matrix:
    """Rotation of one eyeball from the weights of its four eyeLook channels.

    Parameters
    ----------
    eye : Eye
        Gives the side and the degrees at weight 1.
    up, down, inward, outward : float
        Weights, 0..1; inward is towards the nose.

    Returns
    -------
    ndarray of float64, shape (3, 3)

    Examples
    --------
    >>> left = Eye("eye", "Left", (30.0, 0.0, 0.0), 30.0, 30.0, 90.0, 40.0)
    >>> (eye_rotation(left, 0, 0, 1, 0) @ [0, 0, 1]).round(6).tolist()  # to the speaker's right
    [-1.0, 0.0, 0.0]
    """
    to_the_left = outward * eye.look_out - inward * eye.look_in
    yaw = to_the_left if eye.side == "Left" else -to_the_left
    return head_rotation(yaw, up * eye.look_up - down * eye.look_down, 0.0)


@dataclass(frozen=True)
class PosedPart:
    """One part as it stands: vertices (n, 3) in millimetres and unit normals (n, 3), both float32."""

    vertices: Floats
    normals: Floats


@dataclass(frozen=True)
class PosedFace:
    """A face in one pose; ``parts`` in the order of ``Face.parts``, ``channels`` those not at 0 (for its folds)."""

    parts: tuple[PosedPart, ...]
    channels: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class _Surface:
    """All parts of a face laid end to end, as the kernels want them."""

    starts: tuple[int, ...]  # first vertex of each part, and the end
    rest: Floats
    rest_normals: Floats
    triangles: Indices
    head_weight: Floats
    welded: Indices  # (n,) the first vertex that each one shares its normal with
    block_vertex: Indices  # (blocks, BLOCK) the vertices that targets or the neck move; some are there twice
    block_rest: Floats  # (blocks, 3 BLOCK) their x, y and z
    block_share: Floats  # (blocks, BLOCK) how far each takes part in the turn
    block_turn: Indices  # (blocks,) number of the turn: 0 the head's, then the eyes'
    block_start: Indices  # (blocks + 1,) its entries
    entry_column: Indices  # (entries,) a channel
    entry_offset: Floats  # (entries, 3 BLOCK) how it moves the block
    eye_span: Indices  # (eyes, 2) first vertex and end
    eye_centre: Floats  # (eyes, 3)
    pivot: Floats
    angles: (
        Matrix  # (3 (1 + eyes), channels) radians of yaw, -pitch and -roll of head and eyes for each channel's value
    )
    turned: Indices  # (spans, 3) first vertex, end and turn (-1 for none) of vertices in no block
    stiff: Indices  # (spans, 3) likewise, of those that keep their normals at rest but for the turn
    rings: Rings  # of all others


class Poser:
    """Turns rows of channel values into posed faces.

    Parameters
    ----------
    face : Face
    channel_names : sequence of str
        What the columns of a row mean. A channel that moves no part of this face has no effect.

    Raises
    ------
    InputError
        If a name is neither in `mien.core.channels.ALL` nor a target of the face, or repeats.
    """

    def __init__(self, face: Face, channel_names: Sequence[str]) -> None:
        targets = {name for part in face.parts for name in part.targets}
        for name in channel_names:
            if name not in targets and name not in ALL:
                raise unknown_name("channel", name, targets | set(ALL))
        if len(set(channel_names)) != len(channel_names):
            raise InputError("channel names for posing repeat; give each once")
        self.face = face
        self.channel_names = tuple(channel_names)
        self._column = {name: column for column, name in enumerate(channel_names)}
        self._surface = _surface(face, self._column)

    def pose(self, values: ArrayLike) -> PosedFace:
        """The face at one row of channel values.

        Parameters
        ----------
        values : array_like, shape (channels,)
            In the order of ``channel_names``; 0..1, head angles in degrees.

        Raises
        ------
        InputError
            If the row has another length.
        """
        row = self._checked(values)
        surface, rings = self._surface, self._surface.rings
        # One piece of memory: two would be given back to the system, and cleared by it, for every pose of a large face.
        vertices, normals = np.empty((2, *surface.rest.shape), np.float32)
        turns = np.empty((1 + len(surface.eye_centre), 3, 3), np.float32)
        shifts = np.empty((len(turns), 3), np.float32)
        _set_up_turns(surface.angles @ row, surface.pivot, surface.eye_centre, turns, shifts)
        _turn(surface.turned, surface.rest, turns, shifts, vertices)
        _move_blocks(
            surface.block_vertex, surface.block_rest, surface.block_share, surface.block_turn, surface.block_start,
            surface.entry_column, surface.entry_offset, row.astype(np.float32), turns, shifts, vertices,
        )  # fmt: skip
        _turn(surface.stiff, surface.rest_normals, turns, np.zeros_like(shifts), normals)
        ring_normals(vertices, rings.vertex, rings.start, rings.points, rings.twins, normals)
        return replace(_split(surface, vertices, normals), channels=self._moved(row))

    def _moved(self, row: NDArray[np.float64]) -> dict[str, float]:
        return {name: value for name, value in zip(self.channel_names, row.tolist(), strict=True) if value}

    def _checked(self, values: ArrayLike) -> NDArray[np.float64]:
        row = np.asarray(values, dtype=np.float64)
        if row.shape != (len(self.channel_names),):
            raise InputError(f"a row to pose has {len(self.channel_names)} channels, got an array of shape {row.shape}")
        return row

    def _rotations(self, row: NDArray[np.float64]) -> tuple[Matrix, Matrix]:
        def value(name: str) -> float:
            return float(row[self._column[name]]) if name in self._column else 0.0

        turns = np.empty((len(self.face.eyes), 3, 3))
        for number, eye in enumerate(self.face.eyes):
            looks = [value(f"eyeLook{way}{eye.side}") for way in ("Up", "Down", "In", "Out")]
            turns[number] = eye_rotation(eye, looks[0], looks[1], looks[2], looks[3])
        return turns, head_rotation(value("headYaw"), value("headPitch"), value("headRoll"))


def pose_reference(poser: Poser, values: ArrayLike) -> PosedFace:
    """The same as ``poser.pose(values)`` in plain numpy: slower, and easier to check by eye."""
    row, surface = poser._checked(values), poser._surface
    turns, head = poser._rotations(row)
    vertices = surface.rest.astype(np.float64)
    for part, start in zip(poser.face.parts, surface.starts, strict=False):
        for name, target in part.targets.items():
            if name in poser._column:
                weight = row[poser._column[name]]
                np.add.at(vertices, target.vertices + start, weight * target.offsets)
    for (first, end), centre, turn in zip(surface.eye_span, surface.eye_centre, turns, strict=True):
        vertices[first:end] = (vertices[first:end] - centre) @ turn.T + centre
    turned = (vertices - surface.pivot) @ head.T + surface.pivot
    vertices += surface.head_weight[:, None] * (turned - vertices)
    corner = vertices[surface.triangles]
    across = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    total = np.zeros_like(vertices)
    for column in range(3):
        np.add.at(total, surface.welded[surface.triangles[:, column]], across)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    forward = np.array([0, 0, 1], dtype=np.float32)
    normals = np.where(length > 0, total / np.where(length > 0, length, 1), forward)[surface.welded]
    posed = _split(surface, vertices.astype(np.float32), normals.astype(np.float32))
    return replace(posed, channels=poser._moved(row))


def _split(surface: _Surface, vertices: Floats, normals: Floats) -> PosedFace:
    spans = zip(surface.starts, surface.starts[1:], strict=False)
    return PosedFace(tuple(PosedPart(vertices[first:end], normals[first:end]) for first, end in spans))


def _surface(face: Face, column: dict[str, int]) -> _Surface:
    starts = [0, *np.cumsum([len(part.vertices) for part in face.parts]).tolist()]
    names = [part.name for part in face.parts]
    weights = [part.head_weight for part in face.parts]
    for eye in face.eyes:
        weights[names.index(eye.part)] = np.ones_like(weights[names.index(eye.part)])
    triangles = _indices([part.triangles + start for part, start in zip(face.parts, starts, strict=False)])
    triangles = triangles.reshape(-1, 3)
    welded = _indices([welded_vertices(part) + start for part, start in zip(face.parts, starts, strict=False)])
    rest, rings = _floats([part.vertices for part in face.parts], 3), rings_of(triangles, welded)
    rest_normals = np.empty_like(rest)
    ring_normals(rest, rings.vertex, rings.start, rings.points, rings.twins, rest_normals)
    head_weight = np.concatenate([np.zeros(0, np.float32), *weights]).astype(np.float32)
    eye_parts = [names.index(eye.part) for eye in face.eyes]
    eye_span = np.array([(starts[p], starts[p + 1]) for p in eye_parts], dtype=np.int32).reshape(-1, 2)
    turn = np.where(head_weight == 1, 0, np.where(head_weight == 0, _UNTURNED, _APART))
    for number, (first, end) in enumerate(eye_span):
        turn[first:end] = 1 + number
    moves = _moves(face, starts, column)
    loose = (turn == _APART) | moves.any(axis=0)
    alive = _alive(triangles, welded, turn, loose)
    return _Surface(
        starts=tuple(starts),
        rest=rest,
        rest_normals=rest_normals,
        triangles=triangles,
        head_weight=head_weight,
        welded=welded,
        **_blocks(face, starts, column, moves, loose, np.maximum(turn, 0), head_weight, rest),
        eye_span=eye_span,
        eye_centre=np.array([eye.centre for eye in face.eyes], dtype=np.float32).reshape(-1, 3),
        pivot=np.array(face.head_pivot, dtype=np.float32),
        angles=_angles(face.eyes, column),
        turned=_spans(np.where(loose, _APART, turn)),
        stiff=_spans(np.where(alive, _APART, turn)),
        rings=rings.of(alive),
    )


def _angles(eyes: Sequence[Eye], column: Mapping[str, int]) -> Matrix:
    """What `head_rotation` and `eye_rotation` make of each channel, in radians about y, x and z."""
    degrees = np.zeros((1 + len(eyes), 3, len(column)))
    for axis, name in enumerate(("headYaw", "headPitch", "headRoll")):
        if name in column:
            degrees[0, axis, column[name]] = -1.0 if axis else 1.0
    for number, eye in enumerate(eyes):
        side = 1.0 if eye.side == "Left" else -1.0
        gains = {"Up": (1, -eye.look_up), "Down": (1, eye.look_down), "In": (0, -side * eye.look_in)}
        for way, (axis, gain) in {**gains, "Out": (0, side * eye.look_out)}.items():
            if (name := f"eyeLook{way}{eye.side}") in column:
                degrees[1 + number, axis, column[name]] = gain
    return np.deg2rad(degrees).reshape(3 + 3 * len(eyes), len(column))


def _moves(face: Face, starts: Sequence[int], column: Mapping[str, int]) -> NDArray[np.bool_]:
    """Which channels (columns) move which vertices."""
    moves = np.zeros((len(column), starts[-1]), dtype=np.bool_)
    for part, start in zip(face.parts, starts, strict=False):
        for name, target in part.targets.items():
            if name in column:
                moves[column[name], start + target.vertices[target.offsets.any(axis=1)]] = True
    return moves


def _blocks(
    face: Face,
    starts: Sequence[int],
    column: Mapping[str, int],
    moves: NDArray[np.bool_],
    loose: NDArray[np.bool_],
    turn: NDArray[Any],
    share: Floats,
    rest: Floats,
) -> dict[str, Any]:
    """The loose vertices in blocks of those that turn alike and that the same channels move."""
    most_first = np.argsort(moves.sum(axis=1), kind="stable")
    listed = np.flatnonzero(loose)
    listed = listed[np.lexsort([*moves[most_first][:, listed], turn[listed]])]
    groups = [listed[turn[listed] == number] for number in np.unique(turn[listed])]
    filled = [np.append(group, np.repeat(group[-1:], -len(group) % _BLOCK)).reshape(-1, _BLOCK) for group in groups]
    vertex = np.concatenate([np.zeros((0, _BLOCK), np.int64), *filled])
    used = moves[:, vertex].any(axis=2).T if len(moves) else np.zeros((len(vertex), 0), dtype=np.bool_)
    block, channel = np.nonzero(used)
    offset = np.zeros((len(block), 3, _BLOCK), np.float32)
    for name, number in column.items():
        dense, entries = np.zeros_like(rest), channel == number
        for part, start in zip(face.parts, starts, strict=False):
            if name in part.targets:
                np.add.at(dense, part.targets[name].vertices + start, part.targets[name].offsets)
        offset[entries] = dense[vertex[block[entries]]].transpose(0, 2, 1)
    return {
        "block_vertex": vertex.astype(np.int32),
        "block_rest": np.ascontiguousarray(rest[vertex].transpose(0, 2, 1)).reshape(-1, 3 * _BLOCK),
        "block_share": share[vertex],
        "block_turn": turn[vertex[:, 0]].astype(np.int32),
        "block_start": np.append(0, np.cumsum(used.sum(axis=1))).astype(np.int32),
        "entry_column": channel.astype(np.int32),
        "entry_offset": offset.reshape(-1, 3 * _BLOCK),
    }


def _alive(triangles: Indices, welded: Indices, turn: NDArray[Any], loose: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Vertices whose normals may change otherwise than by the turn of all that is around them."""
    alive, turns = loose.copy(), turn[triangles]
    bends = loose[triangles].any(axis=1) | (turns != turns[:, :1]).any(axis=1)
    alive[triangles[bends]] = True
    alive[welded[alive]] = True
    return np.asarray(alive[welded])


def _spans(turn: NDArray[Any]) -> Indices:
    """Neighbours that turn alike, but those `_APART`: first vertex, end, turn."""
    ends = np.append(np.flatnonzero(np.diff(turn)) + 1, len(turn))[: len(turn)]
    firsts = np.append(0, ends)[: len(ends)]
    spans = np.stack([firsts, ends, turn[firsts]], axis=1).astype(np.int32)
    return np.asarray(spans[spans[:, 2] != _APART])


def _floats(pieces: Sequence[NDArray[np.float32]], width: int) -> Floats:
    return np.concatenate([np.zeros((0, width), np.float32), *pieces]).astype(np.float32)


def _indices(pieces: Sequence[NDArray[np.int32]]) -> Indices:
    return np.concatenate([np.zeros(0, np.int32), *(piece.reshape(-1) for piece in pieces)]).astype(np.int32)


def welded_vertices(part: Part, told_apart_by: ArrayLike | None = None) -> Indices:
    """For each vertex the first one that lies *and moves* with it (lips that touch at rest stay two surfaces).

    ``told_apart_by`` (vertices,) keeps apart what moves by other means than targets.
    """
    mixture = np.zeros((len(part.vertices), 3))
    for number, name in enumerate(sorted(part.targets)):
        target = part.targets[name]
        np.add.at(mixture, target.vertices, (1.0 + 0.6180339887 * number) * target.offsets.astype(np.float64))
    if told_apart_by is not None:
        mixture = np.column_stack([mixture, np.asarray(told_apart_by, dtype=np.float64)])
    key = np.round(np.hstack([part.vertices, mixture]) / _WELD_MM).astype(np.int64)
    order = np.lexsort(key.T)  # stable: of equal vertices the first comes first
    starts = np.concatenate([[True], (key[order[1:]] != key[order[:-1]]).any(axis=1)])[: len(order)]
    welded = np.empty(len(order), dtype=np.int32)
    welded[order] = order[starts][np.cumsum(starts) - 1]
    return welded


@njit(cache=True, error_model="numpy", nogil=True)
def _set_up_turns(angles, pivot, centre, turns, shifts):  # type: ignore[no-untyped-def]
    """Fill the rotations of the head, and of the eyes and then the head, and what is added after each."""
    for n in range(turns.shape[0]):
        y, p, r = angles[3 * n], angles[3 * n + 1], angles[3 * n + 2]
        sy, cy, sp, cp, sr, cr = np.sin(y), np.cos(y), np.sin(p), np.cos(p), np.sin(r), np.cos(r)
        own = np.array(
            [
                [cy * cr + sy * sp * sr, sy * sp * cr - cy * sr, sy * cp],
                [cp * sr, cp * cr, -sp],
                [cy * sp * sr - sy * cr, sy * sr + cy * sp * cr, cy * cp],
            ]
        )
        if n == 0:
            head, about = own, pivot
        else:
            about = centre[n - 1]
        for i in range(3):
            moved = np.float64(about[i])
            for k in range(3):
                moved -= own[i, k] * about[k]
            turns[n, i], shifts[n, i] = own[i], moved
        if n > 0:
            for i in range(3):
                moved = np.float64(shifts[0, i])
                for k in range(3):
                    moved += head[i, k] * shifts[n, k]
                    turns[n, i, k] = head[i, 0] * own[0, k] + head[i, 1] * own[1, k] + head[i, 2] * own[2, k]
                angles[i] = moved
            for i in range(3):
                shifts[n, i] = angles[i]


@njit(cache=True, error_model="numpy", nogil=True)
def _move_blocks(  # type: ignore[no-untyped-def]  # numba infers the types; the arrays are those of _Surface
    listed, rest, share, block_turn, start, column, offset, weights, turns, shifts, vertices
):
    """Pose block after block: all in it that changes is read once, and added up in the nearest memory."""
    place = np.empty(3 * _BLOCK, np.float32)
    for block in range(listed.shape[0]):
        for i in range(3 * _BLOCK):
            place[i] = rest[block, i]
        for entry in range(start[block], start[block + 1]):
            weight = weights[column[entry]]
            if weight != 0.0:
                for i in range(3 * _BLOCK):
                    place[i] += weight * offset[entry, i]
        turn, shift = turns[block_turn[block]], shifts[block_turn[block]]
        a, b, c, d, e, f = turn[0, 0], turn[0, 1], turn[0, 2], turn[1, 0], turn[1, 1], turn[1, 2]
        g, h, k, sx, sy, sz = turn[2, 0], turn[2, 1], turn[2, 2], shift[0], shift[1], shift[2]
        for i in range(_BLOCK):
            x, y, z, part = place[i], place[_BLOCK + i], place[2 * _BLOCK + i], share[block, i]
            place[i] = x + part * (a * x + b * y + c * z + sx - x)
            place[_BLOCK + i] = y + part * (d * x + e * y + f * z + sy - y)
            place[2 * _BLOCK + i] = z + part * (g * x + h * y + k * z + sz - z)
        for i in range(_BLOCK):
            v = np.uint64(listed[block, i])
            vertices[v, 0], vertices[v, 1], vertices[v, 2] = place[i], place[_BLOCK + i], place[2 * _BLOCK + i]


@njit(cache=True, error_model="numpy", nogil=True)
def _turn(spans, source, turns, shifts, goal):  # type: ignore[no-untyped-def]
    """Places, or directions (``shifts`` of 0), of what turns as one; as they are where the number of the turn is -1."""
    for span in range(spans.shape[0]):
        first, end = np.uint64(spans[span, 0]), np.uint64(spans[span, 1])
        if spans[span, 2] < 0:
            goal[first:end] = source[first:end]
            continue
        turn, shift = turns[spans[span, 2]], shifts[spans[span, 2]]
        a, b, c, d, e, f = turn[0, 0], turn[0, 1], turn[0, 2], turn[1, 0], turn[1, 1], turn[1, 2]
        g, h, i, sx, sy, sz = turn[2, 0], turn[2, 1], turn[2, 2], shift[0], shift[1], shift[2]
        for v in range(first, end):
            x, y, z = source[v, 0], source[v, 1], source[v, 2]
            goal[v, 0] = a * x + b * y + c * z + sx
            goal[v, 1] = d * x + e * y + f * z + sy
            goal[v, 2] = g * x + h * y + i * z + sz
