"""Parameters from example poses: principal components of sculpted, digitised or simulated meshes.

Frydrych et al. 2003, section 2.2.2: "typically based on statistical analysis of selected facial poses".

Offsets of every pose from rest are centred and split into principal components. Each component is a field of offsets
over the mesh and becomes one parameter: up to three translations on one drive
(`mien.face.tree_of_face.translations_of`), scaled so that value 1 is one standard deviation over the poses. What all
poses share (their mean) is a parameter of its own, ``pose_mean``, where it is not negligible: at 1, with the components
at the scores of a pose, the pose comes back.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mien.core.errors import InputError
from mien.face.obj import MESH, Mesh, read_obj
from mien.face.parameter_tree import ParameterTree
from mien.face.tree_of_face import translations_of

__all__ = ["PoseParameters", "parameters_of_poses", "read_poses"]

Floats = NDArray[np.float64]
_SMALLEST = 1e-6  # share of the mesh's size: means and components below it are none


@dataclass(frozen=True, eq=False)
class PoseParameters:
    """What example poses gave.

    Attributes
    ----------
    tree : ParameterTree
        Driven by ``pose_mean``, ``pose_1``, ``pose_2``...
    shares : tuple of float
        Share of the variance that each component explains.
    scores : ndarray, shape (poses, components)
        Values of ``pose_1``... that bring each pose back.
    errors : ndarray, shape (poses,)
        RMS distance over the vertices between each pose and what the parameters make of it, in the mesh's unit.
    about : str
        The same in words.
    """

    tree: ParameterTree
    shares: tuple[float, ...]
    scores: Floats
    errors: Floats
    about: str


def read_poses(paths: Sequence[str | Path], rest: str | Path | None = None) -> tuple[Mesh, Floats]:
    """Read poses of one mesh.

    Returns
    -------
    rest : Mesh
        The first pose where none is given.
    poses : ndarray, shape (poses, vertices, 3)

    Raises
    ------
    InputError
        If a file cannot be read, or has another number of vertices or other faces than the rest.
    """
    still = read_obj(rest if rest is not None else paths[0])
    name = rest if rest is not None else paths[0]
    poses = []
    for path in paths:
        mesh = read_obj(path)
        if len(mesh.vertices) != len(still.vertices):
            raise InputError(
                f"{path}: {len(mesh.vertices)} vertices, {name} has {len(still.vertices)}: poses are of one mesh"
            )
        if len(mesh.triangles) and len(still.triangles) and not np.array_equal(mesh.triangles, still.triangles):
            raise InputError(f"{path}: its faces are not those of {name}: poses are of one mesh")
        poses.append(mesh.vertices)
    return still, np.array(poses)


def parameters_of_poses(
    rest: Mesh, poses: ArrayLike, count: int | None = None, variance: float = 0.95, directions: int = 3
) -> PoseParameters:
    """Principal components of poses as parameters of a tree.

    Parameters
    ----------
    rest : Mesh
    poses : array_like, shape (poses, vertices, 3)
    count : int or None
        How many components; None keeps the share ``variance``.
    variance : float
        In (0, 1].
    directions : int
        Translations per component, 1 to 3.

    Raises
    ------
    InputError
        If there are fewer than two poses, a setting is out of range, or all poses are alike.
    """
    given = np.asarray(poses, dtype=np.float64)
    if len(given) < 2:
        raise InputError(f"principal components need two poses or more, got {len(given)}")
    if not 0 < variance <= 1:
        raise InputError(f"a share of variance lies above 0 and up to 1, not {variance:g}")
    if count is not None and not 1 <= count <= len(given) - 1:
        raise InputError(f"{len(given)} poses have 1 to {len(given) - 1} components, not {count}")
    offsets = (given - rest.vertices).reshape(len(given), -1)
    mean = offsets.mean(axis=0)
    left, sizes, components = np.linalg.svd(offsets - mean, full_matrices=False)
    size = float(np.ptp(rest.vertices, axis=0).max())
    sizes = np.where(sizes > _SMALLEST * size, sizes, 0.0)
    if not sizes.any():
        raise InputError("all poses are alike: there is nothing to derive parameters from")
    explained = sizes**2 / (sizes**2).sum()
    enough = 1 + int(np.searchsorted(np.cumsum(explained), variance - 1e-12))
    kept = min(count if count is not None else enough, int(np.count_nonzero(sizes)))
    spread = sizes[:kept] / np.sqrt(len(given))
    flips = np.sign(components[np.arange(kept), np.abs(components[:kept]).argmax(axis=1)])
    fields = components[:kept] * (spread * flips)[:, None]
    scores = left[:, :kept] * np.sqrt(len(given)) * flips
    return _told(rest, given, mean, fields, scores, explained[:kept], directions)


def _told(
    rest: Mesh, poses: Floats, mean: Floats, fields: Floats, scores: Floats, shares: Floats, directions: int
) -> PoseParameters:
    parameters = []
    size = float(np.ptp(rest.vertices, axis=0).max())
    named = [("pose_mean", mean)] if np.abs(mean).max() > _SMALLEST * size else []
    named += [(f"pose_{number}", field) for number, field in enumerate(fields, 1)]
    for name, field in named:
        parameters += translations_of(
            name, {MESH: field.reshape(-1, 3)}, {name: 1.0}, None, directions, kept=1.0, smallest=_SMALLEST * size
        )
    tree = ParameterTree(parameters)
    errors = []
    for pose, score in zip(poses, scores, strict=True):
        values = {f"pose_{number}": float(value) for number, value in enumerate(score, 1)} | {"pose_mean": 1.0}
        made = tree.deform(MESH, rest.vertices, tree.values(values))
        errors.append(float(np.sqrt(((made - pose) ** 2).sum(axis=1).mean())))
    count = len(rest.vertices)
    lines = [f"principal components of {len(poses)} poses of {count} vertices, {directions} directions each"]
    lines += [
        f"pose_{number}: {100 * share:.2f} % of the variance, scores {min(column):.2f} to {max(column):.2f}"
        for number, (share, column) in enumerate(zip(shares, scores.T, strict=True), 1)
    ]
    lines.append(f"poses come back within {max(errors):.4g} (RMS over vertices, the worst pose; unit of the mesh)")
    return PoseParameters(tree, tuple(float(s) for s in shares), scores, np.array(errors), "\n".join(lines))
