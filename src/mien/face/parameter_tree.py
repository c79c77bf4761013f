"""The parameter tree of Frydrych et al. 2003 (section 2.2): rotations and translations of regions of any polygon model.

Row vectors in homogeneous coordinates: a point is ``[x y z 1]`` and is moved by multiplying a 4x4 matrix from the
right. A parameter ``k`` at value ``v`` has a matrix ``T_k(v)`` and, per vertex ``i``, a weight ``w_ik``. Parameters
form a tree; a child moves with its parent::

    T'_child = T_child * T'_parent                                                        (the paper's third equation)

Group 1 (skeletal: head, jaw, eyes) is applied first, with weights that are normalised to sum to 1 at each vertex::

    stage 1    P1_i = P_i * (I + sum_k w_ik (T'_k - I))                                   k in group 1

Group 2 (surface: the leaves) works on the result with weights as they are::

    stage 2    P2_i = P1_i * (I + sum_k w_ik (M_k - I))                                   k in group 2

The paper's text has ``M_k = T'_k``: it applies a leaf's parents a second time to vertices that stage 1 has already
moved (a leaf at zero with weight .5 under a head turned by 20 degrees moves a vertex 80 mm from the axis by 13.9 mm).
That reading is kept as ``literal=True``. What is meant is the leaf's own motion in the axes of its moved parent::

    M_k = T'_p^-1 * T_k * T'_p                                                            p the parent of k

so that a leaf at zero changes nothing, however the head stands. Vertices that no skeletal parameter claims stay where
they are in stage 1 (an identity root takes them).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mien.core.errors import InputError

__all__ = ["Influence", "Parameter", "ParameterTree", "rotation_matrix", "translation_matrix"]

Matrix = NDArray[np.float64]
Floats = NDArray[np.float64]
KINDS = ("rotation", "translation", "fixed")


@dataclass(frozen=True, eq=False)
class Influence:
    """Which vertices of one part a parameter moves, and how much: indices (k,) and weights (k,)."""

    vertices: NDArray[np.int32]
    weights: NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Parameter:
    """One parameter of the tree.

    Attributes
    ----------
    name : str
    kind : {"rotation", "translation", "fixed"}
        ``fixed`` never moves: it holds vertices (the trunk) against its siblings in group 1.
    vector : tuple of 3 float
        Axis of a rotation (right-handed, any length); millimetres of a translation at value 1.
    pivot : tuple of 3 float
        A point on the axis of a rotation, mm.
    parent : str or None
    skeletal : bool
        Whether it belongs to group 1.
    drives : mapping of str to float
        ``value = sum of gain * channel``; degrees for a rotation, a factor for a translation.
    limits : tuple of 2 float or None
        Between which the value is kept.
    influences : mapping of str to Influence
        By name of the face's part.
    """

    name: str
    kind: str
    vector: tuple[float, float, float] = (0.0, 0.0, 0.0)
    pivot: tuple[float, float, float] = (0.0, 0.0, 0.0)
    parent: str | None = None
    skeletal: bool = False
    drives: Mapping[str, float] = field(default_factory=dict)
    limits: tuple[float, float] | None = None
    influences: Mapping[str, Influence] = field(default_factory=dict)

    def matrix(self, value: float) -> Matrix:
        """``T(value)``, shape (4, 4), for row vectors."""
        if self.kind == "rotation":
            return rotation_matrix(self.vector, self.pivot, value)
        if self.kind == "translation":
            return translation_matrix(np.multiply(self.vector, value))
        return np.eye(4)

    def value(self, channels: Mapping[str, float]) -> float:
        """The value that channel values ask for."""
        wanted = sum(gain * channels.get(name, 0.0) for name, gain in self.drives.items())
        return wanted if self.limits is None else min(max(wanted, self.limits[0]), self.limits[1])


def translation_matrix(offset: ArrayLike) -> Matrix:
    """Homogeneous translation for row vectors.

    Examples
    --------
    >>> ([1.0, 2.0, 3.0, 1.0] @ translation_matrix([10, 0, 0])).tolist()
    [11.0, 2.0, 3.0, 1.0]
    """
    matrix = np.eye(4)
    matrix[3, :3] = offset
    return matrix


def rotation_matrix(axis: ArrayLike, pivot: ArrayLike, degrees: float) -> Matrix:
    """Homogeneous rotation about an axis through a point, for row vectors (Rodrigues' formula).

    Examples
    --------
    >>> ([1.0, 0.0, 0.0, 1.0] @ rotation_matrix([0, 0, 2], [0, 0, 5], 90)).round(9).tolist()
    [0.0, 1.0, 0.0, 1.0]
    """
    unit = np.asarray(axis, dtype=np.float64)
    unit = unit / np.linalg.norm(unit)
    x, y, z = unit
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = np.deg2rad(degrees)
    turn = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    matrix = np.eye(4)
    matrix[:3, :3] = turn.T
    point = np.asarray(pivot, dtype=np.float64)
    matrix[3, :3] = point - point @ turn.T
    return matrix


class ParameterTree:
    """Parameters in a tree, checked when made.

    Parameters
    ----------
    parameters : sequence of Parameter
        In any order.
    literal : bool
        Stage 2 as the paper's text has it (see the module).

    Raises
    ------
    InputError
        If names repeat, a parent is missing, parents run in a circle, a surface parameter has children, an axis or a
        number is unusable; the message lists every fault.
    """

    def __init__(self, parameters: Sequence[Parameter], literal: bool = False) -> None:
        faults = tree_faults(parameters)
        if faults:
            raise InputError("parameter tree: " + "; ".join(text for _, text in faults))
        self.parameters = _parents_first(parameters)
        self.literal = literal

    def __len__(self) -> int:
        return len(self.parameters)

    @cached_property
    def parents(self) -> NDArray[np.int64]:
        """Index of each parameter's parent, -1 for none."""
        index = {parameter.name: number for number, parameter in enumerate(self.parameters)}
        return np.array([-1 if p.parent is None else index[p.parent] for p in self.parameters], dtype=np.int64)

    @cached_property
    def driven_by(self) -> frozenset[str]:
        """Names of all channels that drive something."""
        return frozenset(name for parameter in self.parameters for name in parameter.drives)

    def values(self, channels: Mapping[str, float]) -> Floats:
        """Values of all parameters at given channel values, shape (parameters,)."""
        return np.array([parameter.value(channels) for parameter in self.parameters])

    def matrices(self, values: ArrayLike) -> Matrix:
        """The matrix of each parameter as its stage applies it, shape (parameters, 4, 4)."""
        given = np.asarray(values, dtype=np.float64)
        total, applied = np.empty((len(self), 4, 4)), np.empty((len(self), 4, 4))
        for k, (parameter, parent) in enumerate(zip(self.parameters, self.parents, strict=True)):
            own = parameter.matrix(float(given[k]))
            above = np.eye(4) if parent < 0 else total[parent]
            total[k] = own @ above
            surface = not parameter.skeletal and not self.literal
            applied[k] = np.linalg.inv(above) @ own @ above if surface else total[k]
        return applied

    def skeletal_weights(self, part: str, count: int) -> Floats:
        """Normalised weights of group 1 on the vertices of a part, shape (parameters, count); zero rows in group 2.

        The columns of vertices that nothing claims are zero: the identity root has them.
        """
        weights = np.zeros((len(self), count))
        for k, parameter in enumerate(self.parameters):
            if parameter.skeletal and part in parameter.influences:
                influence = parameter.influences[part]
                weights[k, influence.vertices] = influence.weights
        total = weights.sum(axis=0)
        return np.where(total > 0, weights / np.where(total > 0, total, 1.0), 0.0)

    def deform(self, part: str, vertices: ArrayLike, values: ArrayLike) -> Floats:
        """Vertices of a part at parameter values: the equations as they stand, in double precision.

        `mien.face.tree_posing.TreePoser` does the same fast; this is its referee.

        Parameters
        ----------
        part : str
        vertices : array_like, shape (n, 3)
            At rest, mm.
        values : array_like, shape (parameters,)

        Returns
        -------
        ndarray, shape (n, 3)
        """
        rest = np.asarray(vertices, dtype=np.float64)
        points = np.hstack([rest, np.ones((len(rest), 1))])
        matrices, identity = self.matrices(values), np.eye(4)
        skeletal = self.skeletal_weights(part, len(points))
        blend = np.broadcast_to(identity, (len(points), 4, 4)) + np.einsum("kn,kab->nab", skeletal, matrices - identity)
        points = np.einsum("na,nab->nb", points, blend)
        blend = np.tile(identity, (len(points), 1, 1))
        for k, parameter in enumerate(self.parameters):
            if not parameter.skeletal and part in parameter.influences:
                influence = parameter.influences[part]
                step = influence.weights[:, None, None].astype(np.float64) * (matrices[k] - identity)
                np.add.at(blend, influence.vertices, step)
        return np.asarray(np.einsum("na,nab->nb", points, blend)[:, :3])


def tree_faults(parameters: Sequence[Parameter]) -> list[tuple[str, str]]:
    """What is wrong with a tree: (name of the parameter, what is wrong with it)."""
    names = [parameter.name for parameter in parameters]
    by_name = {parameter.name: parameter for parameter in parameters}
    faults = [(name, f"{name}: the name is taken twice") for name in sorted(n for n in by_name if names.count(n) > 1)]
    for parameter in parameters:
        faults += [(parameter.name, f"{parameter.name}: {fault}") for fault in _own_faults(parameter, by_name)]
    return faults


def _own_faults(parameter: Parameter, by_name: Mapping[str, Parameter]) -> list[str]:
    faults = []
    if parameter.kind not in KINDS:
        faults.append(f"kind {parameter.kind!r} is none of {', '.join(KINDS)}")
    if parameter.kind == "rotation" and not np.linalg.norm(parameter.vector) > 0:
        faults.append("the axis of a rotation has no length")
    numbers = [*parameter.vector, *parameter.pivot, *parameter.drives.values(), *(parameter.limits or ())]
    if not np.isfinite(numbers).all():
        faults.append("a number is not finite")
    if parameter.limits is not None and parameter.limits[0] > parameter.limits[1]:
        faults.append(f"limits run from {parameter.limits[0]:g} down to {parameter.limits[1]:g}")
    if parameter.parent is not None:
        faults += _parent_faults(parameter, by_name)
    below = [repr(part) for part, influence in parameter.influences.items() if (influence.weights < 0).any()]
    if parameter.skeletal and below:
        faults.append(
            f"weights below zero on {', '.join(below)}; skeletal weights are normalised and cannot be negative"
        )
    return faults


def _parent_faults(parameter: Parameter, by_name: Mapping[str, Parameter]) -> list[str]:
    parent = by_name.get(parameter.parent or "")
    if parent is None:
        return [f"its parent {parameter.parent!r} is not in the tree"]
    seen, above = {parameter.name}, parent
    while above.parent is not None and above.name not in seen:
        seen.add(above.name)
        if above.parent not in by_name:
            break
        above = by_name[above.parent]
    if above.name == parameter.name:
        return [f"its parents run in a circle ({' > '.join(sorted(seen))})"]
    if not parent.skeletal:
        return [f"its parent {parent.name!r} is a surface parameter; only skeletal ones have children"]
    return []


def _parents_first(parameters: Sequence[Parameter]) -> tuple[Parameter, ...]:
    by_name = {parameter.name: parameter for parameter in parameters}

    depths: dict[str, int] = {}
    for parameter in parameters:
        chain = [parameter]  # walked, not recursed into: trees may be deeper than Python's stack
        while chain[-1].parent is not None and chain[-1].name not in depths:
            chain.append(by_name[chain[-1].parent])
        for link in reversed(chain):
            depths.setdefault(link.name, 0 if link.parent is None else 1 + depths[link.parent])
    return tuple(sorted(parameters, key=lambda parameter: depths[parameter.name]))
