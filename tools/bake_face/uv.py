"""Texture coordinates for a head that is one open sheet (a disc with the neck as its border): no seams at all.

The border goes onto a square, the inside is a convex-combination map (Tutte 1963), then the weights are adapted
until every triangle gets a share of the picture near the share asked for (after Yoshizawa, Belyaev and Seidel 2004).
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sparse
from makehuman import Floats, Ints
from scipy.sparse.linalg import spsolve
from subdivision import triangulate

_ROUNDS = 12


def border_loops(faces: Ints) -> list[Ints]:
    """Closed border curves of a mesh, longest first, each in order."""
    sides = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
    known = {(int(a), int(b)) for a, b in sides}
    after = {a: b for a, b in known if (b, a) not in known}
    loops = []
    while after:
        start, follow = next(iter(sorted(after.items())))
        loop = [start]
        del after[start]
        while follow != start:
            loop.append(follow)
            follow = after.pop(follow)
        loops.append(np.array(loop))
    return sorted(loops, key=len, reverse=True)


def _square(vertices: Floats, loop: Ints, first: int) -> Floats:
    """Places on the unit square's rim, by length along the loop, its entry ``first`` amid the first side."""
    loop = np.roll(loop, -first)
    steps = np.linalg.norm(vertices[np.roll(loop, -1)] - vertices[loop], axis=1)
    along = 0.5 + 4 * np.r_[0, np.cumsum(steps)[:-1]] / steps.sum()
    side, share = along.astype(int) % 4, along % 1
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
    return np.roll(corners[side] + share[:, None] * (np.roll(corners, -1, axis=0) - corners)[side], first, axis=0)


def _areas(points: Floats, triangles: Ints) -> Floats:
    a, b, c = (points[triangles[:, k]] for k in range(3))
    cross = np.cross(b - a, c - a)
    return np.linalg.norm(cross, axis=1) / 2 if cross.ndim == 2 else np.abs(cross) / 2


def unfold(vertices: Floats, quads: Ints, density: Floats, first: int) -> Floats:
    """Texture coordinates in the unit square, shape (n, 2).

    Parameters
    ----------
    density : ndarray, shape (n,)
        How much of the picture a square millimetre about a vertex should get, relative to the others.
    first : int
        Which vertex of the longest border loop lies in the middle of a side of the square.
    """
    n = len(vertices)
    rim, *holes = border_loops(quads)
    triangles = triangulate(quads)
    capped = [triangles]
    points = vertices
    for hole in holes:
        hub = len(points)
        points = np.vstack([points, vertices[hole].mean(0)])
        capped.append(np.stack([np.roll(hole, -1), hole, np.full(len(hole), hub)], axis=1))
    triangles = np.vstack(capped)
    density = np.r_[density, np.full(len(holes), density.min())]
    wanted = _areas(points, triangles) * density[triangles].mean(1)
    wanted /= wanted.sum()
    fixed = _square(vertices, rim, first)
    sides = np.unique(np.sort(np.vstack([triangles[:, [i, (i + 1) % 3]] for i in range(3)]), axis=1), axis=0)
    weight = np.ones(len(sides))
    best, best_spread = np.zeros((len(points), 2)), np.inf
    for _ in range(_ROUNDS):
        flat = _convex_map(len(points), sides, weight, rim, fixed)
        stretch = np.sqrt(wanted / np.maximum(_areas(flat, triangles), 1e-12))
        spread = float((wanted * np.abs(np.log(stretch))).sum())
        if spread < best_spread:
            best, best_spread = flat, spread
        at_vertex = np.zeros(len(points))
        share = np.zeros(len(points))
        for k in range(3):
            np.add.at(at_vertex, triangles[:, k], wanted * stretch)
            np.add.at(share, triangles[:, k], wanted)
        at_vertex /= share
        weight = weight / np.sqrt(at_vertex[sides[:, 0]] * at_vertex[sides[:, 1]])
    return best[:n]


def _convex_map(n: int, sides: Ints, weight: Floats, rim: Ints, fixed: Floats) -> Floats:
    links = sparse.csr_matrix((weight, (sides[:, 0], sides[:, 1])), (n, n))
    links = links + links.T
    laplace = sparse.diags(np.asarray(links.sum(1)).ravel()) - links
    inner = np.setdiff1d(np.arange(n), rim)
    flat = np.zeros((n, 2))
    flat[rim] = fixed
    right = -laplace[inner][:, rim] @ fixed
    flat[inner] = spsolve(laplace[inner][:, inner].tocsc(), right)
    return flat
