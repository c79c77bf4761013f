"""Posing a face: from channel values to vertices and normals.

The steps, in order:

1. every part's sparse targets are added, weighed by their channels;
2. eyeballs turn rigidly about their centres (`eye_rotation`);
3. the head turns about its pivot (`head_rotation`), each vertex by its ``head_weight``: positions run on the straight
   line between the unturned and the turned place (eyeballs go with the head in full);
4. normals are the area-weighted mean of the triangles around a vertex. Vertices that lie and move together (the two
   sides of a seam in the texture) share one normal.

`Poser` runs compiled loops; `pose_reference` says the same in plain numpy and is the referee of the tests.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mien.core.channels import ALL
from mien.core.compiled import njit
from mien.core.errors import InputError, unknown_name
from mien.face.model import Eye, Face, Part, Target

__all__ = ["PosedFace", "PosedPart", "Poser", "eye_rotation", "head_rotation", "pose_reference", "welded_vertices"]

Floats = NDArray[np.float32]
Indices = NDArray[np.int32]
Matrix = NDArray[np.float64]

# Vertices closer than this (mm), at rest and in a mixture of all targets, are one point of the surface.
_WELD_MM = 1e-3
_GAP = 8  # vertices that do not move between two that do, at most, within one run


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
    y, p, r = np.deg2rad((yaw, -pitch, -roll))
    about_y = np.array([[np.cos(y), 0, np.sin(y)], [0, 1, 0], [-np.sin(y), 0, np.cos(y)]])
    about_x = np.array([[1, 0, 0], [0, np.cos(p), -np.sin(p)], [0, np.sin(p), np.cos(p)]])
    about_z = np.array([[np.cos(r), -np.sin(r), 0], [np.sin(r), np.cos(r), 0], [0, 0, 1]])
    return np.asarray(about_y @ about_x @ about_z, dtype=np.float64)


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
    triangles: Indices
    head_weight: Floats
    welded: Indices  # (n,) the first vertex that each one shares its normal with
    shaded: Indices  # (t, 3) triangles of welded vertices
    target_column: Indices  # (targets,) channel of each target
    target_start: Indices  # (targets + 1,) its runs: neighbouring vertices that it moves
    run_vertex: Indices  # (runs,) where each run begins
    run_start: Indices  # (runs + 1,) its offsets
    target_offset: Floats
    eye_span: Indices  # (eyes, 2) first vertex and end
    eye_centre: Floats  # (eyes, 3)
    pivot: Floats


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
        surface, (turns, head) = self._surface, self._rotations(row)
        vertices, normals = np.empty_like(surface.rest), np.empty_like(surface.rest)
        _pose_kernel(
            surface.rest,
            surface.triangles,
            surface.shaded,
            surface.head_weight,
            surface.welded,
            surface.target_start,
            surface.run_vertex,
            surface.run_start,
            surface.target_offset.reshape(-1),
            row[surface.target_column].astype(np.float32),
            surface.eye_span,
            surface.eye_centre,
            turns,
            head,
            surface.pivot,
            vertices,
            vertices.reshape(-1),
            normals,
        )
        return replace(_split(surface, vertices, normals), channels=self._moved(row))

    def _moved(self, row: NDArray[np.float64]) -> dict[str, float]:
        return {self.channel_names[place]: float(row[place]) for place in np.flatnonzero(row)}

    def _checked(self, values: ArrayLike) -> NDArray[np.float64]:
        row = np.asarray(values, dtype=np.float64)
        if row.shape != (len(self.channel_names),):
            raise InputError(f"a row to pose has {len(self.channel_names)} channels, got an array of shape {row.shape}")
        return row

    def _rotations(self, row: NDArray[np.float64]) -> tuple[Floats, Floats]:
        def value(name: str) -> float:
            return float(row[self._column[name]]) if name in self._column else 0.0

        turns = np.empty((len(self.face.eyes), 3, 3), dtype=np.float32)
        for number, eye in enumerate(self.face.eyes):
            looks = [value(f"eyeLook{way}{eye.side}") for way in ("Up", "Down", "In", "Out")]
            turns[number] = eye_rotation(eye, looks[0], looks[1], looks[2], looks[3])
        return turns, head_rotation(value("headYaw"), value("headPitch"), value("headRoll")).astype(np.float32)


def pose_reference(poser: Poser, values: ArrayLike) -> PosedFace:
    """The same as ``poser.pose(values)`` in plain numpy: slower, and easier to check by eye."""
    row, surface = poser._checked(values), poser._surface
    turns, head = poser._rotations(row)
    vertices = surface.rest.copy()
    for part, start in zip(poser.face.parts, surface.starts, strict=False):
        for name, target in part.targets.items():
            if name in poser._column:
                weight = np.float32(row[poser._column[name]])
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
    return replace(_split(surface, vertices, normals.astype(np.float32)), channels=poser._moved(row))


def _split(surface: _Surface, vertices: Floats, normals: Floats) -> PosedFace:
    spans = zip(surface.starts, surface.starts[1:], strict=False)
    return PosedFace(tuple(PosedPart(vertices[first:end], normals[first:end]) for first, end in spans))


def _surface(face: Face, column: dict[str, int]) -> _Surface:
    starts = [0, *np.cumsum([len(part.vertices) for part in face.parts]).tolist()]
    names = [part.name for part in face.parts]
    weights = [part.head_weight for part in face.parts]
    for eye in face.eyes:
        weights[names.index(eye.part)] = np.ones_like(weights[names.index(eye.part)])
    moved = [
        (column[name], _runs(target, start))
        for part, start in zip(face.parts, starts, strict=False)
        for name, target in part.targets.items()
        if name in column
    ]
    runs = [run for _, found in moved for run in found]
    triangles = _indices([part.triangles + start for part, start in zip(face.parts, starts, strict=False)])
    welded = _indices([welded_vertices(part) + start for part, start in zip(face.parts, starts, strict=False)])
    eye_parts = [names.index(eye.part) for eye in face.eyes]
    return _Surface(
        starts=tuple(starts),
        rest=_floats([part.vertices for part in face.parts], 3),
        triangles=triangles.reshape(-1, 3),
        shaded=welded[triangles].reshape(-1, 3),
        head_weight=np.concatenate([np.zeros(0, np.float32), *weights]).astype(np.float32),
        welded=welded,
        target_column=np.array([entry[0] for entry in moved], dtype=np.int32),
        target_start=np.cumsum([0, *(len(entry[1]) for entry in moved)]).astype(np.int32),
        run_vertex=np.array([run[0] for run in runs], dtype=np.int32),
        run_start=np.cumsum([0, *(len(run[1]) for run in runs)]).astype(np.int32),
        target_offset=_floats([run[1] for run in runs], 3),
        eye_span=np.array([(starts[p], starts[p + 1]) for p in eye_parts], dtype=np.int32).reshape(-1, 2),
        eye_centre=np.array([eye.centre for eye in face.eyes], dtype=np.float32).reshape(-1, 3),
        pivot=np.array(face.head_pivot, dtype=np.float32),
    )


def _runs(target: Target, start: int) -> list[tuple[int, Floats]]:
    """A target as runs of neighbouring vertices: (first vertex, offsets (k, 3)); gaps up to `_GAP` hold zeros.

    Adding a run needs no list of vertices and goes eight numbers at a time: three times as fast as one by one.
    """
    if not len(target.vertices):
        return []
    order = np.unique(target.vertices)
    first = int(order[0])
    dense = np.zeros((int(order[-1]) - first + 1, 3), np.float32)
    np.add.at(dense, target.vertices - first, target.offsets)
    ends = np.append(np.flatnonzero(np.diff(order) > _GAP), len(order) - 1)
    begins = np.append(0, ends[:-1] + 1)
    return [
        (int(order[a]) + start, dense[order[a] - first : order[b] - first + 1])
        for a, b in zip(begins, ends, strict=True)
    ]


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
def _pose_kernel(  # type: ignore[no-untyped-def]  # numba infers the types; the arrays are those of _Surface
    rest, triangles, shaded, head_weight, welded, target_start, run_vertex, run_start, target_offset, weights,
    eye_span, eye_centre, eye_turn, head_turn, pivot, vertices, numbers, normals,
):  # fmt: skip
    """``numbers`` are the vertices as one row of numbers, ``target_offset`` likewise."""
    count = rest.shape[0]
    vertices[:] = rest
    for k in range(weights.shape[0]):
        weight = weights[k]
        if weight == 0.0:
            continue
        for run in range(target_start[k], target_start[k + 1]):
            first, end = 3 * run_start[run], 3 * run_start[run + 1]
            moved = numbers[3 * run_vertex[run] : 3 * run_vertex[run] + end - first]
            offset = target_offset[first:end]
            for i in range(end - first):
                moved[i] += weight * offset[i]
    for e in range(eye_span.shape[0]):
        for v in range(eye_span[e, 0], eye_span[e, 1]):
            _turn(vertices, v, eye_turn[e], eye_centre[e], np.float32(1.0))
    for v in range(count):
        if head_weight[v] != 0.0:
            _turn(vertices, v, head_turn, pivot, head_weight[v])
    _shade(vertices, triangles, shaded, welded, normals)


@njit(cache=True, error_model="numpy", nogil=True)
def shade(vertices, triangles, welded, normals):  # type: ignore[no-untyped-def]
    """Unit normals of vertices as they stand, weighted by area, shared by vertices that are welded."""
    shaded = np.empty_like(triangles)
    for t in range(triangles.shape[0]):
        for k in range(3):
            shaded[t, k] = welded[triangles[t, k]]
    _shade(vertices, triangles, shaded, welded, normals)


@njit(cache=True, error_model="numpy", nogil=True)
def _shade(vertices, triangles, shaded, welded, normals):  # type: ignore[no-untyped-def]
    count = vertices.shape[0]
    normals[:] = 0.0
    for t in range(triangles.shape[0]):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        x, y, z = vertices[a, 0], vertices[a, 1], vertices[a, 2]
        ux, uy, uz = vertices[b, 0] - x, vertices[b, 1] - y, vertices[b, 2] - z
        wx, wy, wz = vertices[c, 0] - x, vertices[c, 1] - y, vertices[c, 2] - z
        nx, ny, nz = uy * wz - uz * wy, uz * wx - ux * wz, ux * wy - uy * wx
        for k in range(3):
            v = shaded[t, k]
            normals[v, 0] += nx
            normals[v, 1] += ny
            normals[v, 2] += nz
    for v in range(count):
        if welded[v] == v:
            nx, ny, nz = normals[v, 0], normals[v, 1], normals[v, 2]
            squared = nx * nx + ny * ny + nz * nz
            if squared > 0.0:
                share = np.float32(1.0) / np.sqrt(squared)
                normals[v, 0], normals[v, 1], normals[v, 2] = nx * share, ny * share, nz * share
            else:
                normals[v, 2] = 1.0
    for v in range(count):
        w = welded[v]
        if w != v:
            normals[v, 0], normals[v, 1], normals[v, 2] = normals[w, 0], normals[w, 1], normals[w, 2]


@njit(cache=True, error_model="numpy", nogil=True)
def _turn(vertices, v, turn, about, share):  # type: ignore[no-untyped-def]
    """Move one vertex by ``share`` of the way to where the rotation takes it."""
    x, y, z = vertices[v, 0] - about[0], vertices[v, 1] - about[1], vertices[v, 2] - about[2]
    vertices[v, 0] += share * (turn[0, 0] * x + turn[0, 1] * y + turn[0, 2] * z - x)
    vertices[v, 1] += share * (turn[1, 0] * x + turn[1, 1] * y + turn[1, 2] * z - y)
    vertices[v, 2] += share * (turn[2, 0] * x + turn[2, 1] * y + turn[2, 2] * z - z)
