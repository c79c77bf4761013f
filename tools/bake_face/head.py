"""The skin: cut out of MakeHuman's body, made finer, with texture coordinates and the masks that painting needs."""

from __future__ import annotations

import json
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse
from character import ORIGINS, mirror_shapes, neutral
from makehuman import Floats, Ints, MakeHuman
from numpy.typing import NDArray
from sculpt import Sculpt, smoothstep
from subdivision import catmull_clark, triangulate
from uv import border_loops, unfold

_MASKS = ("lips", "eyelids", "ears", "inside-mouth")
_NECK_BONES = {"neck03": 0.9, "neck02": 0.6, "neck01": 0.2}


@dataclass
class Head:
    """The fine skin and what else the other modules need to know about it.

    Attributes
    ----------
    skin : Sculpt
    quads : ndarray, shape (q, 4)
        The skin's faces before they were cut into triangles.
    fine_of : dict of int to int
        Fine vertex of each MakeHuman vertex.
    masks : dict of str to ndarray, shape (n,)
        0..1 by name: lips, eyelids, ears, inside-mouth.
    eye_holes : list of ndarray
        Ordered border vertices of the left and the right eye opening.
    lip_loop : ndarray
        Fine vertices, in order, of the line where MakeHuman's lips turn into the mouth's inside.
    eye_centres, eye_radius
        Left and right, mm.
    identity : ndarray
        All MakeHuman vertices of the character, mm about the eyes.
    units : dict of str to ndarray
        The ARKit shapes on all MakeHuman vertices.
    used : ndarray
        The MakeHuman vertices that the skin is made of, and ``refine``, the matrix from those to the skin's.
    """

    skin: Sculpt
    quads: Ints
    fine_of: dict[int, int]
    masks: dict[str, Floats]
    eye_holes: list[Ints]
    lip_loop: Ints
    eye_centres: Floats
    eye_radius: float
    identity: Floats
    units: dict[str, Floats]
    used: Ints
    refine: sparse.csr_matrix


def fit_sphere(points: Floats) -> tuple[Floats, float]:
    """Centre and radius by least squares."""
    system = np.c_[2 * points, np.ones(len(points))]
    solution = np.linalg.lstsq(system, (points**2).sum(1), rcond=None)[0]
    return solution[:3], float(np.sqrt(solution[3] + solution[:3] @ solution[:3]))


def _islands(data: MakeHuman, texture_faces: Ints) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Which faces lie in the sockets, and which in the mouth, told by their place in MakeHuman's texture."""
    centre = data.texture_points[texture_faces].mean(1)
    socket = (centre[:, 0] < 0.17) & (centre[:, 1] > 0.54) & (centre[:, 1] < 0.64)
    mouth = (centre[:, 1] < 0.15) & (centre[:, 0] > 0.7)
    return socket, mouth


def build_head(data: MakeHuman, lowest: float, person: Floats | None = None) -> Head:
    """Cut, refine and unfold; ``lowest`` (mm) is where the trunk ends.

    ``person`` (all MakeHuman vertices, mm) is another character; it is cut and unfolded where the default one is, so
    that the vertices of the two correspond.
    """
    cut, cut_spheres = _about_the_eyes(data, neutral(data))
    identity, spheres = (cut, cut_spheres) if person is None else _about_the_eyes(data, person)
    units = mirror_shapes(data.face_units() | data.expression_units(ORIGINS), data.mirror())
    quads = np.array(data.groups["body"])
    texture_faces = np.array(data.texture_faces["body"])
    socket, mouth = _islands(data, texture_faces)
    keep = (cut[quads][:, :, 1].min(1) > lowest) & (np.abs(cut[quads][:, :, 0]).max(1) < 275) & ~socket
    used, local = np.unique(quads[keep], return_inverse=True)
    local = local.reshape(-1, 4)
    coarse = identity[used]
    in_mouth = np.unique(local[mouth[keep]])
    flat = _unfolded(cut[used], local, in_mouth)
    matrix, fine = catmull_clark(len(used), local)
    triangles = triangulate(fine)
    skin = Sculpt("skin", coarse, local, {k: v[used] for k, v in units.items()}, flat)
    skin.head_weight = _head_weight(data)[used]
    texture_place = np.zeros((len(used), 2))
    texture_place[local.ravel()] = data.texture_points[texture_faces[keep].ravel()]
    masks = {name: np.clip(matrix @ _sample(data.mask(name), texture_place), 0, 1) for name in _MASKS}
    deep = np.zeros(len(used))
    deep[in_mouth] = 1
    masks["inside-mouth"] = matrix @ deep
    skin = skin.through(matrix, triangles)
    holes = [loop for loop in border_loops(fine) if np.abs(skin.vertices[loop][:, 1]).max() < 30]
    holes.sort(key=lambda loop: -skin.vertices[loop][:, 0].mean())
    return Head(
        skin,
        fine,
        {int(v): i for i, v in enumerate(used)},
        masks,
        holes,
        border_loops(local[mouth[keep]])[0],
        np.array([centre for centre, _ in spheres]),
        spheres[0][1],
        identity,
        units,
        used,
        matrix,
    )


def _about_the_eyes(data: MakeHuman, shape: Floats) -> tuple[Floats, list[tuple[Floats, float]]]:
    """A character moved so that the origin lies between its eyes, and the spheres of its eyeballs."""
    spheres = [fit_sphere(shape[data.group_vertices(f"helper-{side}-eye")]) for side in "lr"]
    origin = np.mean([centre for centre, _ in spheres], axis=0)
    return shape - origin, [(centre - origin, radius) for centre, radius in spheres]


def _unfolded(coarse: Floats, quads: Ints, in_mouth: Ints) -> Floats:
    x, y, z = coarse.T
    density = 0.25 + 0.75 * smoothstep(-60, -10, z)
    density *= 1 - 0.75 * smoothstep(-115, -140, y)
    density *= 1 + 1.0 * np.exp(-((np.abs(x) - 30) ** 2 + y**2) / 25**2) + 1.0 * np.exp(-(x**2 + (y + 60) ** 2) / 30**2)
    density[in_mouth] = 0.12
    rim = border_loops(quads)[0]
    return unfold(coarse, quads, density, int(np.argmin(coarse[rim][:, 2])))


def _sample(picture: Floats, places: Floats) -> Floats:
    height, width = picture.shape
    column = np.clip((places[:, 0] * width).astype(int), 0, width - 1)
    row = np.clip(((1 - places[:, 1]) * height).astype(int), 0, height - 1)
    return np.asarray(picture[row, column])


def _head_weight(data: MakeHuman) -> Floats:
    """1 on what the skull or jaw carries, less down the neck, by MakeHuman's rig weights."""
    bones, weights = (json.loads(data.read(f"rigs/standard/{kind}.default.json")) for kind in ("rig", "weights"))

    def share(bone: str) -> float:
        while bone and bone != "head" and bone not in _NECK_BONES:
            bone = bones[bone].get("parent") or ""
        return 1.0 if bone == "head" else _NECK_BONES.get(bone, 0.0)

    total = np.zeros(len(data.vertices))
    for bone, pairs in weights["weights"].items():
        part = share(bone)
        for vertex, weight in pairs:
            total[vertex] += part * weight
    return np.clip(total, 0, 1)
