"""A face laid out for the renderer: what does not change from frame to frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from mien.face.model import Face, Part
from mien.face.normals import normals_of
from mien.face.posing import welded_vertices
from mien.face.render.colour import linear_from_srgb
from mien.face.render.detail import moves as moves_of
from mien.face.render.relief import TILE_MM
from mien.face.row_groups import row_groups
from mien.face.subset import nearest_to_middle, without_flat

__all__ = ["LEVELS", "Scene"]

Floats = NDArray[np.float32]
Indices = NDArray[np.int32]

LEVELS = 12  # of a texture, each half the size of the last
# A part with more than this share of its edges open is a sheet (lashes, brows): seen from both sides, casts none.
_SHEET_SHARE = 0.08
_CASTER_SHARE = 0.02  # of the whole surface; smaller parts (eyeballs, teeth) cast no shadow worth its time
# What lies and moves so close together (mm) casts shadows as one point: those of the key light, those of the others.
_FINE, _COARSE = (2.2, 5.0), (13.0, 24.0)
_FADE_MM = 28.0
_IN_MOUTH, _CAVITY = ("teeth", "tongue", "gum"), 0.8
_HAIR = ("hair", "beard")
_TRUNK = 0.02  # below this head_weight a vertex is of the trunk, above it of the neck (a collar is no cut)
_HALVED_ROWS = 64
_THIN_MM = (2.0, 4.0, 6.0, 8.0)  # depths at which the other side is looked for
_LIFT_HARD, _LIFT_SKIN, _LIFT_OTHERS = 0.7, 2.2, 0.15  # mm
# How lips are told from the skin around them: their red stands out. Wet ones are smoother and shine more (hand-made).
_LIP_REDNESS, _LIP_FULL = 0.10, 0.22
_LIP_ROUGHNESS, _LIP_SPECULAR = 0.60, 1.35


@dataclass(frozen=True)
class Scene:
    """All parts end to end.

    Attributes
    ----------
    starts : tuple of int
        First vertex of each part, and the end.
    triangles : ndarray of int32, shape (triangles, 3)
    triangle_part : ndarray of int32, shape (triangles,)
    sheet : ndarray of bool, shape (parts,)
        Seen from both sides.
    clear : ndarray of bool, shape (parts,)
        Whether something of what is behind is seen through the part.
    opacity : ndarray of float32, shape (parts,)
        Of the whole part; multiplies ``alphas``.
    casters, caster_vertices : ndarray of int32, shapes (some triangles, 3) and (some vertices,)
        What casts the key light's shadows: large parts that are not sheets, between some of their vertices. Corners are
        places in the list of vertices.
    coarse_casters, coarse_vertices : ndarray of int32
        The same between fewer vertices, for the soft lights.
    solid : ndarray of float32, shape (vertices,)
        Opacity: 1, falling to 0 where the trunk is cut off.
    lift : ndarray of float32, shape (vertices,)
        How far off its surface a vertex is held against the shadow maps, mm.
    lit_side : ndarray of int8, shape (vertices,)
        0, or of a sheet: 1, lit on the side that is seen; 2, hair, through which light gets, on the outside.
    cavity : ndarray of float32, shape (vertices,)
        Above 0 for teeth and tongue: as far, lips and cheeks leave of every light what they leave open of the dome.
    spacing : ndarray of float32, shape (vertices,)
        Mean length of the edges at a vertex, mm.
    albedo : ndarray of float32, shape (vertices, 3)
        Linear; vertex colour times material colour.
    gloss : ndarray of float32, shape (vertices, 2)
        Roughness squared (the GGX alpha) and reflectance head-on.
    scatter : ndarray of float32, shape (vertices,)
    thin : ndarray of float32, shape (vertices,)
        How much light comes through from the other side: scatter where flesh is thin (ears, nose, lids), else 0.
    uv : ndarray of float32, shape (vertices, 2)
    texels : ndarray of uint8, shape (n, 3)
        All levels of all textures, row by row.
    alphas : ndarray of uint8, shape (n,)
        Their opacity.
    texture_level : ndarray of int32, shape (parts, LEVELS, 3)
        First texel, width and height of each level; width 0 where a part has no texture.
    tiles : ndarray of float32, shape (parts,)
        How often the relief of skin repeats in a unit of texture coordinates; 0 where there is none.
    neighbour_start, neighbour, neighbour_weight
        Around which vertices light spreads below the skin: rows (vertices + 1,), (edges,), (edges, 3 colours).
    welded : ndarray of int32, shape (vertices,)
        The vertex whose light each one shares.
    head_centre : ndarray of float32, shape (3,)
    head_radius : float
        A ball, mm, that holds the head in any pose; shadows are found inside it.
    """

    starts: tuple[int, ...]
    triangles: Indices
    triangle_part: Indices
    sheet: NDArray[np.bool_]
    clear: NDArray[np.bool_]
    opacity: Floats
    casters: Indices
    coarse_casters: Indices
    caster_vertices: Indices
    coarse_vertices: Indices
    solid: Floats
    lift: Floats
    lit_side: NDArray[np.int8]
    cavity: Floats
    spacing: Floats
    albedo: Floats
    gloss: Floats
    scatter: Floats
    thin: Floats
    uv: Floats
    texels: NDArray[np.uint8]
    alphas: NDArray[np.uint8]
    texture_level: Indices
    tiles: Floats
    neighbour_start: Indices
    neighbour: Indices
    neighbour_weight: Floats
    welded: Indices
    head_centre: Floats
    head_radius: float

    @classmethod
    def of(cls, face: Face, reach_mm: Floats) -> Scene:
        """Lay a face out; ``reach_mm`` as in `mien.face.render.lighting.Lighting`."""
        parts = face.parts
        starts = [0, *np.cumsum([len(part.vertices) for part in parts]).tolist()]
        triangles = np.concatenate([part.triangles + start for part, start in zip(parts, starts, strict=False)])
        vertices = np.concatenate([part.vertices for part in parts])
        own = [welded_vertices(part) for part in parts]
        welded = np.concatenate([each + start for each, start in zip(own, starts, strict=False)])
        rims = [_open_edges(part, each) for part, each in zip(parts, own, strict=True)]
        scatter = np.concatenate([np.full(len(part.vertices), part.material.scatter, np.float32) for part in parts])
        texels, alphas, levels = _textures(parts)
        clear = np.array([_is_clear(part) for part in parts])
        centre, radius = _head_ball(parts)
        sheet = np.array([share > _SHEET_SHARE for _, share in rims])
        casts = _casts(parts) & ~sheet & ~clear
        casting = _triangles_of(parts, starts, casts)
        moves = np.concatenate([moves_of(part) for part in parts])
        owner = np.repeat(np.arange(len(parts)), [len(part.vertices) for part in parts])
        (casters, caster_vertices), (coarse, coarse_vertices) = (
            _coarser(owner, vertices, moves, casting, *near) for near in (_FINE, _COARSE)
        )
        return cls(
            starts=tuple(starts),
            triangles=np.ascontiguousarray(triangles, dtype=np.int32),
            triangle_part=np.concatenate([np.full(len(p.triangles), i, np.int32) for i, p in enumerate(parts)]),
            sheet=sheet,
            clear=clear,
            opacity=np.array([part.material.opacity for part in parts], dtype=np.float32),
            casters=casters,
            coarse_casters=coarse,
            caster_vertices=caster_vertices,
            coarse_vertices=coarse_vertices,
            lift=np.concatenate([_lift(part, each) for part, each in zip(parts, casts, strict=True)]),
            lit_side=np.concatenate(
                [
                    np.full(len(p.vertices), each and 1 + p.name.startswith(_HAIR), np.int8)
                    for p, each in zip(parts, sheet.tolist(), strict=True)
                ]
            ),
            solid=np.concatenate([_solid(part, rim) for part, (rim, _) in zip(parts, rims, strict=True)]),
            cavity=np.concatenate(
                [np.full(len(p.vertices), _CAVITY * p.name.startswith(_IN_MOUTH), np.float32) for p in parts]
            ),
            spacing=np.concatenate([_spacing(part) for part in parts]),
            albedo=np.concatenate(
                [linear_from_srgb(p.colours) * linear_from_srgb(p.material.colour) for p in parts]
            ).astype(np.float32),
            gloss=np.concatenate([_gloss(part) for part in parts]),
            scatter=scatter,
            thin=np.concatenate([_thin(part, each) for part, each in zip(parts, own, strict=True)]),
            uv=np.concatenate([part.uv for part in parts]).astype(np.float32),
            texels=texels,
            alphas=alphas,
            texture_level=levels,
            tiles=np.array([_tiles(part) for part in parts], dtype=np.float32),
            **_neighbours(triangles, vertices, welded, scatter, reach_mm),
            welded=welded.astype(np.int32),
            head_centre=centre,
            head_radius=radius,
        )


def _open_edges(part: Part, welded: Indices) -> tuple[Indices, float]:
    """Vertices on edges with a triangle on one side only, and the share of such edges among all."""
    corner = welded[part.triangles].astype(np.int64)
    edges = np.sort(np.concatenate([corner[:, [0, 1]], corner[:, [1, 2]], corner[:, [2, 0]]]), axis=1)
    count = len(part.vertices)
    numbers, times = np.unique(edges[:, 0] * count + edges[:, 1], return_counts=True)
    rim = numbers[times == 1]
    return np.unique(np.concatenate([rim // count, rim % count])).astype(np.int32), float((times == 1).mean())


def _casts(parts: tuple[Part, ...]) -> NDArray[np.bool_]:
    corners = [part.vertices[part.triangles] for part in parts]
    areas = np.array([np.linalg.norm(np.cross(c[:, 1] - c[:, 0], c[:, 2] - c[:, 0]), axis=1).sum() for c in corners])
    return np.asarray(areas > _CASTER_SHARE * areas.sum())


def _triangles_of(parts: tuple[Part, ...], starts: list[int], chosen: NDArray[np.bool_]) -> Indices:
    pieces = [part.triangles + start for part, start, take in zip(parts, starts, chosen, strict=False) if take]
    return np.ascontiguousarray(np.concatenate([np.zeros((0, 3), np.int32), *pieces]), dtype=np.int32)


def _coarser(
    owner: NDArray[np.int64], vertices: Floats, moves: Floats, triangles: Indices, near_mm: float, move_mm: float
) -> tuple[Indices, Indices]:
    """Triangles between one vertex for each group of those that lie and move together; and these vertices."""
    if not len(triangles):
        return triangles, np.zeros(0, np.int32)
    key = np.hstack([owner[:, None], np.floor(vertices / near_mm), np.rint(moves / move_mm)])
    used = np.unique(triangles)
    group = row_groups(key[used])
    chosen = np.zeros(len(vertices), dtype=np.int64)
    chosen[used] = used[nearest_to_middle(vertices[used], group)][group]
    corner = without_flat(chosen[triangles])
    turned = np.take_along_axis(corner, (corner.argmin(axis=1)[:, None] + np.arange(3)) % 3, axis=1)
    whole = row_groups(turned)
    corner = np.empty((whole.max(initial=-1) + 1, 3), turned.dtype)
    corner[whole] = turned
    kept, places = np.unique(corner, return_inverse=True)
    return np.ascontiguousarray(places.reshape(-1, 3), dtype=np.int32), kept.astype(np.int32)


def _lift(part: Part, casts: np.bool_) -> Floats:
    """A surface that casts must not shade itself, and light gets round the edges of skin; others can lie close."""
    scatter = part.material.scatter
    lift = _LIFT_HARD + scatter * (_LIFT_SKIN - _LIFT_HARD) if casts else _LIFT_OTHERS
    return np.full(len(part.vertices), lift, dtype=np.float32)


def _solid(part: Part, rim: Indices) -> Floats:
    """Fades the trunk out towards the edge where it is cut off, so that a bust does not end in a rim."""
    edge = rim[part.head_weight[rim] < _TRUNK]
    squared = np.full(len(part.vertices), np.inf, dtype=np.float32)
    for point in part.vertices[edge]:
        squared = np.minimum(squared, ((part.vertices - point) ** 2).sum(axis=1))
    return np.clip(np.sqrt(squared) / _FADE_MM, 0, 1).astype(np.float32)


def _thin(part: Part, welded: Indices) -> Floats:
    """Skin that has more skin, turned away from it, so near behind it that light comes through."""
    thin: NDArray[Any] = np.zeros(len(part.vertices), dtype=np.float32)
    if part.material.scatter == 0 or not len(part.triangles):
        return thin
    normals = normals_of(part.vertices, part.triangles, welded)
    tree, others = cKDTree(part.vertices), -0.3 * np.ones(len(thin))
    for depth in _THIN_MM:
        away, nearest = tree.query(part.vertices - np.float32(depth) * normals)
        turned = (normals * normals[nearest]).sum(axis=1) < others
        thin = np.maximum(thin, np.where(turned & (away < _THIN_MM[0]), 1 - 0.5 * depth / _THIN_MM[-1], 0))
    ends = np.concatenate([part.triangles[:, [0, 1]], part.triangles[:, [1, 2]], part.triangles[:, [2, 0]]])
    ends = welded[np.concatenate([ends, ends[:, ::-1]])]
    for _ in range(4):  # no step where it ends
        total = np.bincount(ends[:, 0], thin[ends[:, 1]], len(thin))
        thin = (total / np.maximum(np.bincount(ends[:, 0], minlength=len(thin)), 1))[welded]
    return np.asarray(part.material.scatter * thin, dtype=np.float32)


def _spacing(part: Part) -> Floats:
    ends = np.concatenate([part.triangles[:, [0, 1]], part.triangles[:, [1, 2]], part.triangles[:, [2, 0]]])
    length = np.linalg.norm(part.vertices[ends[:, 0]] - part.vertices[ends[:, 1]], axis=1)
    total, count = (np.bincount(ends.reshape(-1), w, len(part.vertices)) for w in (np.repeat(length, 2), None))
    return (total / np.maximum(count, 1)).astype(np.float32)


def _gloss(part: Part) -> Floats:
    material = part.material
    gloss = np.empty((len(part.vertices), 2), dtype=np.float32)
    wet = np.zeros(len(part.vertices))
    if material.scatter > 0:
        tint = part.colours * _texture_at_vertices(part)
        red = 1 - tint[:, 1] / np.maximum(tint[:, 0], 1e-3)
        wet = np.clip((red - np.median(red) - _LIP_REDNESS) / (_LIP_FULL - _LIP_REDNESS), 0, 1)
    gloss[:, 0] = np.clip(material.roughness * (1 - wet * (1 - _LIP_ROUGHNESS)), 0.08, 1) ** 2
    gloss[:, 1] = 0.08 * material.specular * (1 + wet * (_LIP_SPECULAR - 1))
    return gloss


def _texture_at_vertices(part: Part) -> Floats:
    """The texture's colour around each vertex, sRGB 0..1, shape (n, 3); ones without a texture."""
    picture = part.material.texture
    if picture is None:
        return np.ones_like(part.colours)
    picture = picture[:, :, :3]
    for _ in range(3):  # a vertex stands for an area, not for one freckle
        picture = _halved(picture)
    last = np.array([picture.shape[1] - 1, picture.shape[0] - 1])
    place = np.clip(np.floor(part.uv * (last + 1)).astype(int), 0, last)
    return np.asarray(picture[place[:, 1], place[:, 0]] / 255, dtype=np.float32)


def _tiles(part: Part) -> float:
    """How many tiles of relief a unit of the texture coordinates of skin holds."""
    if part.material.scatter == 0 or part.name.startswith(_IN_MOUTH) or not len(part.triangles):
        return 0.0
    ends = part.triangles[:, :2]
    length = np.linalg.norm(part.vertices[ends[:, 0]] - part.vertices[ends[:, 1]], axis=1)
    spread = np.linalg.norm(part.uv[ends[:, 0]] - part.uv[ends[:, 1]], axis=1)
    known = (spread > 1e-5) & (length > 1e-3)
    return round(float(np.median(length[known] / spread[known])) / TILE_MM) if known.any() else 0.0


def _is_clear(part: Part) -> bool:
    picture = part.material.texture
    return part.material.opacity < 1 or (picture is not None and picture.shape[2] == 4)


def _textures(parts: tuple[Part, ...]) -> tuple[NDArray[np.uint8], NDArray[np.uint8], Indices]:
    levels = np.zeros((len(parts), LEVELS, 3), dtype=np.int32)
    used = 1
    for number, part in enumerate(parts):
        if part.material.texture is not None:
            tall, wide = part.material.texture.shape[:2]
            for level in range(LEVELS):
                levels[number, level] = used, wide, tall
                used, wide, tall = used + wide * tall, max(1, wide // 2), max(1, tall // 2)
    texels, alphas = np.full((used, 3), 255, np.uint8), np.full(used, 255, np.uint8)
    for part, places in zip(parts, levels, strict=True):
        if (picture := part.material.texture) is None:
            continue
        for first, wide, tall in places.tolist():
            here = slice(first, first + wide * tall)
            texels[here] = picture[:, :, :3].reshape(-1, 3)
            if picture.shape[2] == 4:
                alphas[here] = picture[:, :, 3].reshape(-1)
            picture = _halved(picture)
    return texels, alphas, levels


def _halved(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Half the size, by means of 2 x 2 (a side of odd length loses its last row; a side of one stays)."""
    height, width = (max(1, side // 2) for side in picture.shape[:2])
    tall, wide = min(2, picture.shape[0]), min(2, picture.shape[1])
    found = np.empty((height, width, picture.shape[2]), np.uint8)
    for top in range(0, height, _HALVED_ROWS):  # few rows stay in the processor's cache
        rows = picture[tall * top : tall * min(height, top + _HALVED_ROWS)].astype(np.uint16)
        lines = rows[::tall] + rows[1::tall] if tall == 2 else rows
        total = lines[:, : wide * width : wide] + lines[:, 1 : wide * width : wide] if wide == 2 else lines
        found[top : top + len(total)] = (total + tall * wide // 2) // np.uint16(tall * wide)
    return found


def _neighbours(
    triangles: Indices, vertices: Floats, welded: Indices, scatter: Floats, reach_mm: Floats
) -> dict[str, NDArray[Any]]:
    corner = welded[triangles]
    pairs = np.concatenate([corner[:, [a, b]] for a, b in ((0, 1), (1, 2), (2, 0), (1, 0), (2, 1), (0, 2))])
    pairs = pairs[(scatter[pairs[:, 0]] > 0) & (pairs[:, 0] != pairs[:, 1])].astype(np.int64)
    pairs = np.stack(np.divmod(np.unique(pairs[:, 0] * len(vertices) + pairs[:, 1]), len(vertices)), axis=1)
    length = np.linalg.norm(vertices[pairs[:, 0]] - vertices[pairs[:, 1]], axis=1)[:, None]
    reach = np.maximum(reach_mm * scatter[pairs[:, 0]][:, None], 1e-3)
    count = np.bincount(pairs[:, 0], minlength=len(vertices))
    return {
        "neighbour_start": np.concatenate([[0], np.cumsum(count)]).astype(np.int32),
        "neighbour": pairs[:, 1].astype(np.int32),
        "neighbour_weight": np.exp(-0.5 * (length / reach) ** 2).astype(np.float32),
    }


def _head_ball(parts: tuple[Part, ...]) -> tuple[Floats, float]:
    points = np.concatenate([part.vertices[part.head_weight > 0.5] for part in parts])
    low, high = points.min(axis=0), points.max(axis=0)
    centre = ((low + high) / 2).astype(np.float32)
    return centre, 1.15 * float(np.linalg.norm(points - centre, axis=1).max())
