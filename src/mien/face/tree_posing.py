"""Posing a face by its parameter tree, as `Poser` does by morph targets (`ParameterTree.deform` is the referee)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mien.core.channels import ALL
from mien.core.compiled import njit
from mien.core.errors import InputError, unknown_name
from mien.core.facs import au_channels, is_unit
from mien.face.model import Face, Part
from mien.face.normals import ring_normals, rings_of
from mien.face.parameter_tree import ParameterTree
from mien.face.posing import PosedFace, PosedPart, welded_vertices

__all__ = ["TreePoser"]

Floats = NDArray[np.float32]
_SMALLEST = 1e-9  # a matrix nearer to the identity than this moves nothing


class TreePoser:
    """Turns rows of channel values into posed faces by a parameter tree.

    Parameters
    ----------
    face : Face
    channel_names : sequence of str
        What the columns of a row mean: channels, action units (``AU12L``) or other names that drive the tree's
        parameters. A parameter may be driven by an action unit: then that unit's column drives it, and no channel.
    tree : ParameterTree or None
        None takes the face's own.

    Raises
    ------
    InputError
        If the face has no tree, a name is not known, or repeats.
    """

    def __init__(self, face: Face, channel_names: Sequence[str], tree: ParameterTree | None = None) -> None:
        tree = tree or face.tree
        if tree is None:
            raise InputError(f"face {face.name!r} has no parameter tree")
        if len(set(channel_names)) != len(channel_names):
            raise InputError("channel names for posing repeat; give each once")
        self.face, self.tree = face, tree
        self.channel_names = tuple(channel_names)
        targets = {name for part in face.parts for name in part.targets}
        for name in channel_names:
            if name not in ALL and name not in tree.driven_by and name not in targets and not is_unit(name):
                raise unknown_name("channel", name, set(ALL) | tree.driven_by)
        self._gain = _gains(tree, self.channel_names)
        limits = [p.limits or (-np.inf, np.inf) for p in tree.parameters]
        self._limits = np.array(limits, dtype=np.float64).reshape(-1, 2)
        self._lay_out()

    def values(self, row: ArrayLike) -> NDArray[np.float64]:
        """Values of the tree's parameters at one row of channel values."""
        given = np.asarray(row, dtype=np.float64)
        if given.shape != (len(self.channel_names),):
            raise InputError(
                f"a row to pose has {len(self.channel_names)} channels, got an array of shape {given.shape}"
            )
        return np.clip(self._gain @ given, self._limits[:, 0], self._limits[:, 1])

    def pose(self, values: ArrayLike) -> PosedFace:
        """The face at one row of channel values, as `Poser.pose`."""
        steps = self.tree.matrices(self.values(values)) - np.eye(4)
        moving = np.abs(steps).max(axis=(1, 2)) > _SMALLEST
        sliding = np.abs(steps[:, :3]).max(axis=(1, 2)) <= _SMALLEST
        vertices, normals = self._rest.copy(), np.empty_like(self._rest)
        _skeletal(self._rest, self._bone, self._start, self._vertex, self._weight, moving, steps, vertices)
        _surface(vertices.copy(), self._leaf, self._start, self._vertex, self._weight, moving, sliding, steps, vertices)
        rings = self._rings
        ring_normals(vertices, rings.vertex, rings.start, rings.points, rings.twins, normals)
        spans = zip(self._starts, self._starts[1:], strict=False)
        return PosedFace(tuple(PosedPart(vertices[first:end], normals[first:end]) for first, end in spans))

    def _lay_out(self) -> None:
        face, tree = self.face, self.tree
        self._starts = [0, *np.cumsum([len(part.vertices) for part in face.parts]).tolist()]
        offset = {part.name: start for part, start in zip(face.parts, self._starts, strict=False)}
        skeletal = {part.name: tree.skeletal_weights(part.name, len(part.vertices)) for part in face.parts}
        vertices: list[NDArray[np.int32]] = []
        weights: list[Floats] = []
        for k, parameter in enumerate(tree.parameters):
            for part in face.parts:
                if part.name not in parameter.influences:
                    continue
                chosen = parameter.influences[part.name].vertices
                given = (
                    skeletal[part.name][k, chosen] if parameter.skeletal else parameter.influences[part.name].weights
                )
                vertices.append((chosen + offset[part.name]).astype(np.int32))
                weights.append(given.astype(np.float32))
        sizes = [
            sum(
                len(parameter.influences[part.name].vertices)
                for part in face.parts
                if part.name in parameter.influences
            )
            for parameter in tree.parameters
        ]
        self._start = np.cumsum([0, *sizes]).astype(np.int64)
        self._vertex = np.concatenate([np.zeros(0, np.int32), *vertices])
        self._weight = np.concatenate([np.zeros(0, np.float32), *weights])
        self._bone = np.array([p.skeletal for p in tree.parameters], dtype=np.bool_)
        self._leaf = ~self._bone
        self._rest = np.concatenate([np.zeros((0, 3), np.float32), *(part.vertices for part in face.parts)])
        welded = [
            welded_vertices(part, _mixture(tree, part)) + start
            for part, start in zip(face.parts, self._starts, strict=False)
        ]
        triangles = [part.triangles + start for part, start in zip(face.parts, self._starts, strict=False)]
        self._rings = rings_of(np.concatenate(triangles).astype(np.int32), np.concatenate(welded).astype(np.int32))


def _mixture(tree: ParameterTree, part: Part) -> NDArray[np.float64]:
    """A number per vertex that differs where parameters weigh differently."""
    mixture = np.zeros(len(part.vertices))
    for k, parameter in enumerate(tree.parameters):
        if part.name in parameter.influences:
            influence = parameter.influences[part.name]
            np.add.at(mixture, influence.vertices, (1.0 + 0.6180339887 * k) * influence.weights.astype(np.float64))
    return mixture


def _gains(tree: ParameterTree, names: Sequence[str]) -> NDArray[np.float64]:
    """Value of every parameter per unit of every column, shape (parameters, columns)."""
    gains = np.zeros((len(tree), len(names)))
    for column, name in enumerate(names):
        spelt = {name: 1.0}
        if is_unit(name) and name not in tree.driven_by:
            spelt = au_channels(name)
        for k, parameter in enumerate(tree.parameters):
            gains[k, column] = sum(parameter.drives.get(channel, 0.0) * share for channel, share in spelt.items())
    return gains


@njit(cache=True, error_model="numpy", nogil=True)
def _skeletal(rest, bone, start, vertex, weight, moving, steps, vertices):  # type: ignore[no-untyped-def]
    """Stage 1: ``vertices`` holds the rest and takes the sum of the weighted moves of group 1."""
    for k in range(bone.shape[0]):
        if not bone[k] or not moving[k]:
            continue
        step = steps[k]
        for i in range(start[k], start[k + 1]):
            v, w = vertex[i], weight[i]
            x, y, z = rest[v, 0], rest[v, 1], rest[v, 2]
            for c in range(3):
                vertices[v, c] += w * (x * step[0, c] + y * step[1, c] + z * step[2, c] + step[3, c])


@njit(cache=True, error_model="numpy", nogil=True)
def _surface(before, leaf, start, vertex, weight, moving, sliding, steps, vertices):  # type: ignore[no-untyped-def]
    """Stage 2: ``before`` is what stage 1 made; translations are the same for all vertices."""
    for k in range(leaf.shape[0]):
        if not leaf[k] or not moving[k]:
            continue
        step = steps[k]
        for i in range(start[k], start[k + 1]):
            v, w = vertex[i], weight[i]
            if sliding[k]:
                for c in range(3):
                    vertices[v, c] += w * step[3, c]
            else:
                x, y, z = before[v, 0], before[v, 1], before[v, 2]
                for c in range(3):
                    vertices[v, c] += w * (x * step[0, c] + y * step[1, c] + z * step[2, c] + step[3, c])
