"""Texture coordinates for a head that has none: cut open at the back, laid out flat without a fold.

A seam runs from the crown down the back to the neck; along it vertices are doubled. What is cut open is laid into a
circle by mean value coordinates (Floater 2003), whose weights are positive, so that no triangle can turn over (Tutte
1963; holes are closed for the time by a point in their middle). Weights are then divided by the local stretch a few
times (Yoshizawa, Belyaev, Seidel 2004), which gives nose, ears and the mouth's inside more of the picture.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.sparse.linalg import splu

from mien.core.errors import InputError
from mien.face.model import Part, Target
from mien.face.surface import coded_sides, open_edges

__all__ = ["Unwrapped", "flat", "layout_picture", "unwrapped"]

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

_RADIUS, _BACK_MM = 0.48, 12.0
_ROUNDS, _DAMPED = 30, 0.5
_CORNER = 0.06  # of the picture: where pieces that hang apart from the head go


@dataclass(frozen=True, eq=False)
class Unwrapped:
    """A skin with texture coordinates.

    Attributes
    ----------
    part : Part
        Vertices along the seam are doubled, copies behind all others.
    turned : int
        Triangles of the head's surface that lie the wrong way round: 0 where the surface is sound.
    spread : float
        How unevenly the picture is shared out: 90 % of the surface has between 1/spread and spread times its share.
    """

    part: Part
    turned: int
    spread: float


def unwrapped(part: Part, where: str = "the head") -> Unwrapped:
    """Give a skin texture coordinates.

    Parameters
    ----------
    part : Part
        In the face's axes (mm, y up, z forward).
    where : str
        Names it in errors.

    Raises
    ------
    InputError
        If its surface cannot be cut open and laid flat (three faces at one edge).

    Examples
    --------
    >>> from mien.face.library import load_face
    >>> done = unwrapped(load_face("default").part("skin"))
    >>> done.turned
    0
    """
    vertices = part.vertices.astype(np.float64)
    _, stands = np.unique(vertices.round(4), axis=0, return_inverse=True)
    triangles = stands.ravel()[part.triangles].astype(np.int64)
    points = np.zeros((int(triangles.max()) + 1, 3))
    points[stands.ravel()[part.triangles].ravel()] = vertices[part.triangles.ravel()]
    sound = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)
    chosen = sound & _largest(triangles, points)
    seam = _seam(points, triangles[chosen])
    corners = _corner_classes(triangles[chosen], seam)
    source = np.zeros(int(corners.max()) + 1, dtype=np.int64)
    source[corners.ravel()] = triangles[chosen].ravel()
    places = flat(points[source], corners, source[_seam_numbers(source, seam)], where, source)
    return _put_on(part, triangles, chosen, corners, places)


def _largest(triangles: Indices, points: Floats) -> NDArray[np.bool_]:
    """Triangles of the connected piece with the largest surface."""
    graph = _graph(triangles, len(points), np.ones(3 * len(triangles)))
    label = connected_components(graph, directed=False)[1][triangles[:, 0]]
    return np.asarray(label == np.bincount(label, _areas(points[triangles])).argmax())


def _areas(corner: Floats) -> Floats:
    return np.asarray(np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1) / 2)


def _graph(triangles: Indices, count: int, weights: Floats) -> sparse.csr_matrix:
    rows, columns = triangles.T.ravel(), np.roll(triangles, -1, axis=1).T.ravel()
    both = sparse.coo_matrix((weights, (rows, columns)), (count, count)).tocsr()
    return both.maximum(both.T)


def _seam(points: Floats, triangles: Indices) -> Indices:
    """Vertices from the crown down the back to the neck's rim (or to the lowest place of a closed surface)."""
    used = np.unique(triangles)
    place = points[used]
    top = used[np.argmin(np.abs(place[:, 0]) + 2 * (place[:, 1].max() - place[:, 1]))]
    rims = _loops(open_edges(triangles.astype(np.int32)))
    low = min(rims, key=lambda loop: points[loop, 1].min()) if rims else used[[np.argmin(place[:, 1])]]
    ends = triangles.T.ravel(), np.roll(triangles, -1, axis=1).T.ravel()
    middle = (points[ends[0]] + points[ends[1]]) / 2
    front = np.maximum(middle[:, 2] - np.median(place[:, 2]), 0)
    cost = np.linalg.norm(points[ends[0]] - points[ends[1]], axis=1) + 1e-6
    cost *= 1 + (np.abs(middle[:, 0]) + 4 * front) / _BACK_MM
    on_rim = np.zeros(len(points), dtype=np.bool_)
    for loop in rims:
        on_rim[loop] = True
    cost[on_rim[ends[0]] | on_rim[ends[1]]] += 1e4  # by a rim only where it has to be
    way, before = dijkstra(_graph(triangles, len(points), cost), indices=top, return_predecessors=True)
    path = [int(low[np.argmin(way[low])])]
    while before[path[-1]] >= 0:
        path.append(int(before[path[-1]]))
    return np.array(path[::-1])


def _loops(edges: NDArray[np.int32]) -> list[Indices]:
    """Vertices of each connected set of edges."""
    if not len(edges):
        return []
    used, ends = np.unique(edges, return_inverse=True)
    ends = ends.reshape(-1, 2)
    graph = sparse.coo_matrix((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), (len(used), len(used)))
    count, label = connected_components(graph, directed=False)
    return [used[label == k].astype(np.int64) for k in range(count)]


def _corner_classes(triangles: Indices, seam: Indices) -> Indices:
    """New numbers of all corners: those of one vertex are one where edges that are not cut join their triangles."""
    code, count = coded_sides(triangles.astype(np.int32))
    cut = np.minimum(seam[:-1], seam[1:]) * count + np.maximum(seam[:-1], seam[1:])
    order = np.argsort(code, kind="stable")
    same = np.flatnonzero((code[order[1:]] == code[order[:-1]]) & ~np.isin(code[order[1:]], cut))
    one, other = order[same], order[same + 1]
    total = len(triangles)
    start, stop = np.arange(3 * total), (np.arange(3 * total) + total) % (3 * total)  # corners at a side's two ends
    vertex = triangles.T.ravel()
    alike = vertex[start[one]] == vertex[start[other]]
    rows = np.concatenate([start[one], stop[one]])
    columns = np.concatenate([np.where(alike, start[other], stop[other]), np.where(alike, stop[other], start[other])])
    graph = sparse.coo_matrix((np.ones(len(rows)), (rows, columns)), (3 * total, 3 * total))
    return np.asarray(connected_components(graph, directed=False)[1].reshape(3, total).T, dtype=np.int64)


def _seam_numbers(source: Indices, seam: Indices) -> Indices:
    """The new number of the seam's upper end."""
    return np.flatnonzero(source == seam[0])[:1]


def flat(
    points: Floats, triangles: Indices, top: Indices, where: str = "the head", source: Indices | None = None
) -> Floats:
    """Lay a surface with a rim into a circle.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    triangles : ndarray, shape (t, 3)
    top : ndarray of int
        Holds the vertex (by ``source``, the same number by default) of the rim that comes to the top of the circle.
    where : str
        Names it in errors.
    source : ndarray of int, shape (n,), optional

    Returns
    -------
    ndarray, shape (n, 2)
        In 0..1, from the upper left corner.

    Raises
    ------
    InputError
        If its rim is none that can be walked round.
    """
    source = np.arange(len(points)) if source is None else source
    rims = _loops(open_edges(triangles.astype(np.int32)))
    outer = next((loop for loop in rims if np.isin(source[loop], top).any()), None)
    ring = None if outer is None else _walked(triangles, outer, int(outer[np.isin(source[outer], top)][0]))
    if ring is None:
        raise InputError(f"{where}: its surface cannot be laid flat: faces meet three at an edge, or touch at points")
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points[ring], axis=0), axis=1))])
    turn = 2 * np.pi * arc / (arc[-1] + np.linalg.norm(points[ring[0]] - points[ring[-1]]))
    held = np.full((len(points), 2), np.nan)
    held[ring] = 0.5 + _RADIUS * np.stack([np.sin(turn), -np.cos(turn)], axis=1)  # as seen from outside
    faces, whole = triangles, points
    for loop in rims:
        if loop is not outer:
            walk = _walked(triangles, loop, int(loop[0]))
            if walk is None:
                raise InputError(f"{where}: its surface cannot be laid flat: holes of it touch at points")
            lid = np.stack([walk, np.roll(walk, -1), np.full(len(walk), len(whole))], axis=1)
            whole, faces = np.vstack([whole, points[walk].mean(axis=0)]), np.vstack([faces, lid])
    held = np.vstack([held, np.full((len(whole) - len(points), 2), np.nan)])
    return _relaxed(whole, faces, held, len(triangles))[: len(points)]


def _walked(triangles: Indices, loop: Indices, first: int) -> Indices | None:
    """A rim's vertices in the order in which they follow one another, against the way of its triangles."""
    rows, columns = triangles.T.ravel(), np.roll(triangles, -1, axis=1).T.ravel()
    mine = np.isin(rows, loop) & np.isin(columns, loop)
    sides = set(zip(rows[mine].tolist(), columns[mine].tolist(), strict=True))
    after: dict[int, int] = {}
    for one, other in sides:
        if (other, one) not in sides:
            if other in after:
                return None
            after[other] = one
    ring = [first]
    while after.get(ring[-1], first) != first and len(ring) <= len(loop):
        ring.append(after[ring[-1]])
    return np.array(ring) if len(ring) == len(loop) else None


def _relaxed(points: Floats, triangles: Indices, held: Floats, real: int) -> Floats:
    """Mean value coordinates, their weights divided by the stretch as long as that evens it."""
    rows, columns, weights = _mean_value_weights(points, triangles)
    best, least = held, np.inf
    stretch = np.ones(len(points))
    for _ in range(_ROUNDS):
        weights = np.clip(weights / stretch[columns], 1e-12, 1e12)
        places = _solved(rows, columns, weights, held)
        stretch, total = _stretch(points, places, triangles[:real])
        if not total < least:
            break
        best, least = places, total
    return best


def _mean_value_weights(points: Floats, triangles: Indices) -> tuple[Indices, Indices, Floats]:
    """For each corner the two edges out of it, weighted by half the tangent of its angle over the edge's length."""
    found: list[tuple[Indices, Indices, Floats]] = []
    for k in range(3):
        a, b, c = (triangles[:, (k + step) % 3] for step in range(3))
        one, other = points[b] - points[a], points[c] - points[a]
        long, far = (np.maximum(np.linalg.norm(edge, axis=1), 1e-9) for edge in (one, other))
        cosine = np.clip((one * other).sum(axis=1) / (long * far), -0.9999, 0.999999)
        half = np.sqrt((1 - cosine) / (1 + cosine))
        found += [(a, b, half / long), (a, c, half / far)]
    rows, columns, weights = (np.concatenate(each) for each in zip(*found, strict=True))
    return rows, columns, weights


def _solved(rows: Indices, columns: Indices, weights: Floats, held: Floats) -> Floats:
    free = np.flatnonzero(np.isnan(held[:, 0]))
    number = np.full(len(held), -1)
    number[free] = np.arange(len(free))
    mine = number[rows] >= 0
    rows, columns, weights = number[rows[mine]], columns[mine], weights[mine]
    weights = weights / np.bincount(rows, weights, len(free))[rows]
    inner = number[columns] >= 0
    inside = sparse.coo_matrix((weights[inner], (rows[inner], number[columns[inner]])), (len(free), len(free)))
    right = np.zeros((len(free), 2))
    for axis in range(2):
        right[:, axis] = np.bincount(rows[~inner], (weights * held[columns, axis])[~inner], len(free))
    places = held.copy()
    system = (sparse.identity(len(free)) - inside).tocsc()
    places[free] = splu(system, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}).solve(right)
    return places


def _stretch(points: Floats, places: Floats, triangles: Indices) -> tuple[Floats, float]:
    """Root mean square stretch (Sander 2001) of the picture onto the surface.

    At each vertex, damped, about 1 in the middle; and how uneven it is over all.
    """
    corner, flat_corner = points[triangles], places[triangles]
    area = _areas(corner)
    one, other = flat_corner[:, 1] - flat_corner[:, 0], flat_corner[:, 2] - flat_corner[:, 0]
    twice = np.maximum(np.abs(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]), 1e-14)
    a, b = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    along = (a * other[:, 1:] - b * one[:, 1:]) / twice[:, None]
    across = (b * one[:, :1] - a * other[:, :1]) / twice[:, None]
    square = ((along**2).sum(axis=1) + (across**2).sum(axis=1)) / 2
    flat_ends, count = triangles.ravel(), len(points)
    total = np.bincount(flat_ends, np.repeat(area, 3), count)
    mean = np.sqrt(np.bincount(flat_ends, np.repeat(area * square, 3), count) / np.maximum(total, 1e-12))
    mean = np.where(total > 0, mean, 1.0)
    uneven = np.log(np.sqrt(square) / np.exp(np.average(np.log(np.sqrt(square)), weights=area)))
    return np.clip(mean / np.median(mean), 0.1, 10.0) ** _DAMPED, float(np.average(uneven**2, weights=area))


def _put_on(part: Part, triangles: Indices, chosen: NDArray[np.bool_], corners: Indices, places: Floats) -> Unwrapped:
    """The part with coordinates at its vertices: one that has two becomes two."""
    own = part.triangles.astype(np.int64)
    count = len(part.vertices)
    wanted = np.full((len(own), 3), -1, dtype=np.int64)
    wanted[chosen] = corners
    pair = own.ravel() * (len(places) + 1) + wanted.ravel() + 1
    kinds, which = np.unique(pair, return_inverse=True)
    vertex, place = kinds // (len(places) + 1), kinds % (len(places) + 1) - 1
    first = np.concatenate([[True], vertex[1:] != vertex[:-1]])
    number = np.where(first, vertex, count + np.cumsum(~first) - 1)
    copies = vertex[~first]
    source = np.concatenate([np.arange(count), copies])
    uv = np.full((len(source), 2), _CORNER / 2)
    uv[number[place >= 0]] = places[place[place >= 0]]
    apart = np.setdiff1d(number[place < 0], number[place >= 0])
    if len(apart):
        shape = part.vertices[source[apart]][:, :2].astype(np.float64)
        uv[apart] = _CORNER * (shape - shape.min(0)) / max(float(np.ptp(shape, axis=0).max()), 1e-9)
    targets = {name: _with_copies(target, count, copies) for name, target in part.targets.items()}
    done = replace(
        part, vertices=part.vertices[source], triangles=number[which.ravel()].reshape(-1, 3).astype(np.int32),
        uv=uv.astype(np.float32), colours=part.colours[source], head_weight=part.head_weight[source], targets=targets,
    )  # fmt: skip
    signed = _signed(places[corners])
    share = (signed / signed.sum()) / (_areas(part.vertices[own[chosen]].astype(np.float64)) + 1e-9)
    share *= _areas(part.vertices[own[chosen]].astype(np.float64)).sum()
    weight = _areas(part.vertices[own[chosen]].astype(np.float64))
    order = np.argsort(share)
    spot = np.cumsum(weight[order]) / weight.sum()
    low, high = (share[order][np.searchsorted(spot, edge)] for edge in (0.05, 0.95))
    spread = float(max(high, 1 / max(low, 1e-9)))
    return Unwrapped(done, int((signed <= 0).sum()), spread)


def _signed(corner: Floats) -> Floats:
    """Twice the area of flat triangles, positive where they go round as they should (v points down)."""
    one, other = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    return np.asarray(one[:, 1] * other[:, 0] - one[:, 0] * other[:, 1])


def _with_copies(target: Target, count: int, copies: Indices) -> Target:
    place = np.full(count, -1)
    place[target.vertices] = np.arange(len(target.vertices))
    mine = np.flatnonzero(place[copies] >= 0)
    rows = np.concatenate([target.vertices, (count + mine).astype(np.int32)])
    return Target(rows.astype(np.int32), np.concatenate([target.offsets, target.offsets[place[copies[mine]]]]))


def layout_picture(part: Part, size: int = 2048) -> NDArray[np.uint8]:
    """The edges of a part on its picture, to paint over; shape (size, size, 3)."""
    from PIL import Image, ImageDraw

    picture = Image.new("RGB", (size, size), (235, 235, 235))
    pen = ImageDraw.Draw(picture)
    for corner in (part.uv[part.triangles].astype(np.float64) * size).tolist():
        pen.polygon([tuple(place) for place in corner], outline=(60, 60, 60))
    return np.asarray(picture)
