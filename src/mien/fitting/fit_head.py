"""A bare head mesh becomes a `Face`: the 52 ARKit shapes and mien's further ones, eyes, teeth and tongue."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from mien.channels import ARKIT
from mien.errors import InputError, Note
from mien.face.face import Eye, Face, Material, Part, Target
from mien.fitting.alignment import Alignment, align
from mien.fitting.contact import Seam, dense_targets, lid_seam, lip_seam
from mien.fitting.eye_cut import cut_out_eye, eye_patch
from mien.fitting.head_mesh import HeadMesh, Piece, prepared_mesh
from mien.fitting.head_space import HeadSpace, head_space
from mien.fitting.landmarks import places_of_landmarks
from mien.fitting.lip_cut import cut_apart, joined_share
from mien.fitting.reshaping import EyePlace, Reshaped, reshaped_face, sparse_target
from mien.fitting.surface import Surface
from mien.fitting.surface_fit import FitSettings, SurfaceFit, fit_surface
from mien.fitting.transfer import Carried, carry_over, filled
from mien.fitting.warps import Similarity

__all__ = ["ADDED", "FittedHead", "GivenMesh", "fit_head"]

Floats = NDArray[np.float64]
Indices = NDArray[np.int32]

ADDED = ("eyes", "teeth", "tongue", "mouth", "lashes", "brows", "hair", "shirt")
"""What can be added out of the default face where the head has none of its own."""
DEFAULT_ADDED = ("eyes", "teeth", "tongue", "mouth")
_PARTS = {
    "eyes": ("eye_left", "eye_right", "caruncles"),
    "teeth": ("teeth_upper", "teeth_lower"),
    "tongue": ("tongue",),
    "lashes": ("lashes",),
    "brows": ("brows",),
    "hair": ("hair", "hair_clumps"),
    "shirt": ("shirt",),
}
_FOLDED = 0.001  # of the skin's area
_EYE_FILLED = 0.4  # of the opening between the lids
_JOINED = 0.5  # of the mouth's width
_MOUTH_DEPTH_MM = 14.0
_FOLLOWERS_MM = 12.0  # pieces farther than this from the skin do not move with it


@dataclass(frozen=True, eq=False)
class GivenMesh:
    """A mesh as it came from a file; ``texture`` (height, width, 3) with ``uv`` from its upper left corner, or None."""

    vertices: Floats
    triangles: Indices
    uv: Floats
    colours: Floats
    texture: NDArray[np.uint8] | None = None


@dataclass(frozen=True, eq=False)
class FittedHead:
    """The result of `fit_head`.

    Attributes
    ----------
    face : Face
    fit : SurfaceFit
        The default skin bent onto the head.
    alignment : Alignment
    lip_gap, lid_gap : float
        Widest opening left between the lips in ``jawOpen`` with ``mouthClose`` (over what is open at rest), and between
        the lids of either eye in a blink, mm.
    folded : mapping of str to float
        Share of the skin's area that a target at weight 1 turns over, where it is more than on the default face.
    kept : ndarray of int64
        Number in the file of each vertex of the skin's part.
    notes : tuple of Note
    """

    face: Face
    fit: SurfaceFit
    alignment: Alignment
    lip_gap: float
    lid_gap: float
    folded: Mapping[str, float]
    kept: NDArray[np.int64]
    notes: tuple[Note, ...]


def fit_head(
    mesh: GivenMesh,
    landmarks: Mapping[str, tuple[float, ...]],
    name: str = "head",
    unit: str | None = None,
    added: tuple[str, ...] = DEFAULT_ADDED,
    where: str = "the mesh",
    settings: FitSettings | None = None,
) -> FittedHead:
    """Give a bare head mesh the default face's motion.

    Parameters
    ----------
    mesh : GivenMesh
        In any unit and axes.
    landmarks : mapping of str to 3 numbers (a place) or 1 (a vertex)
        As `mien.fitting.landmarks.read_landmarks` reads them.
    name : str
        Of the face.
    unit : str, optional
        One of `mien.fitting.alignment.UNITS`; found from the head's size if not given.
    added : tuple of str
        Of `ADDED`: what the default face lends where the head has none.
    where : str
        Names the mesh in errors.
    settings : FitSettings, optional

    Raises
    ------
    InputError
        If the landmarks or the mesh cannot be used; the message says which.
    """
    space = head_space()
    given = places_of_landmarks(landmarks, mesh.vertices, where)
    alignment = align(given, space, where, unit)
    places = {key: alignment.to_face(place[None])[0] for key, place in given.items()}
    template = alignment.template(space.rest)
    expected = {eye.side: alignment.template(np.array([eye.centre]))[0] for eye in space.face.eyes}
    head = prepared_mesh(
        mesh.vertices, mesh.triangles, alignment.to_face, template, space.triangles, expected, places, where
    )
    surface = Surface(head.vertices, head.welded[head.triangles], head.of("skin"))
    fit = fit_surface(space, surface, places, alignment, settings)
    return _Builder(space, mesh, head, fit, alignment, name, added).build()


class _Builder:
    """Puts the face together once the default skin lies on the head."""

    def __init__(
        self,
        space: HeadSpace,
        mesh: GivenMesh,
        head: HeadMesh,
        fit: SurfaceFit,
        alignment: Alignment,
        name: str,
        added: tuple[str, ...],
    ) -> None:
        self.space, self.mesh, self.fit, self.alignment, self.name, self.added = (
            space,
            mesh,
            fit,
            alignment,
            name,
            added,
        )
        self.notes: list[Note] = [*alignment.notes, *head.notes]
        self.eye_pieces = {p.kind[4:].capitalize(): p for p in head.pieces if p.kind.startswith("eye_")}
        self.head, self.skin = head, fit.vertices
        self._centre_on_eyes()
        known = {s: EyePlace(tuple(p.centre.tolist()), p.radius) for s, p in self.eye_pieces.items()}
        self.reshaped: Reshaped = reshaped_face(space, self.skin, name, known)
        sides = [eye.side for eye in space.face.eyes]
        self.joined_eyes = [side for side in sides if side not in known and self._lids_joined("eye_" + side.lower())]

    def _centre_on_eyes(self) -> None:
        """Move all so that the origin lies midway between the eyeballs' centres."""
        if len(self.eye_pieces) == 2:
            middle = np.mean([piece.centre for piece in self.eye_pieces.values()], axis=0)
        else:
            places = reshaped_face(self.space, self.skin, self.name).face.eyes
            middle = np.mean([eye.centre for eye in places], axis=0)
        shift = Similarity(1.0, np.eye(3), -middle)
        self.head = replace(
            self.head,
            vertices=shift(self.head.vertices),
            pieces=tuple(replace(piece, centre=piece.centre - middle) for piece in self.head.pieces),
        )
        self.eye_pieces = {p.kind[4:].capitalize(): p for p in self.head.pieces if p.kind.startswith("eye_")}
        self.skin = shift(self.skin)

    def build(self) -> FittedHead:
        triangles = self.head.triangles[self.head.of("skin")]
        vertices, triangles, kept = self._numbered(triangles)
        welded = self._welded(triangles, kept)
        vertices, triangles = self._without_eyes(vertices, triangles, welded)
        carried = carry_over(self.space, self.skin, Surface(vertices, welded[triangles]))
        vertices, triangles, kept, welded, carried, cut = self._opened(vertices, triangles, kept, welded, carried)
        carried = _shared(carried, welded)
        targets = self._targets(carried, vertices, welded[triangles])
        seams = self._seams(carried, vertices, welded[triangles])
        lip_gap, lid_gap = self._mend(targets, vertices, seams)
        part = self._skin_part(vertices, triangles, kept, carried, targets)
        parts, eyes = self._other_parts(cut, carried)
        own = self.reshaped.face
        sites = self._sites(vertices, carried)
        face = Face(self.name, (part, *parts), eyes, own.head_pivot, sites, "")
        folded = _folded(vertices, triangles, targets)
        self._tell(folded, lip_gap, lid_gap)
        kept_in_file = self.head.kept[kept]
        return FittedHead(face, self.fit, self.alignment, lip_gap, lid_gap, folded, kept_in_file, tuple(self.notes))

    # ------------------------------------------------------------ the mesh

    def _numbered(self, triangles: Indices) -> tuple[Floats, Indices, NDArray[np.int64]]:
        """The skin's vertices; if it is the only piece, all there are, so that numbers stay those of the file."""
        if all(piece.kind == "skin" for piece in self.head.pieces):
            kept = np.arange(len(self.head.vertices))
        else:
            kept = np.unique(triangles).astype(np.int64)
        number = np.full(len(self.head.vertices), -1, dtype=np.int32)
        number[kept] = np.arange(len(kept))
        return self.head.vertices[kept], number[triangles], kept

    def _welded(self, triangles: Indices, kept: NDArray[np.int64]) -> Indices:
        """The stand-in of each of the skin's vertices, among the skin's own."""
        stands = self.head.welded[kept]
        used = np.zeros(len(kept), dtype=np.bool_)
        used[np.unique(triangles)] = True
        order = np.lexsort((np.arange(len(kept)), ~used, stands))
        first = np.concatenate([[True], np.diff(stands[order]) != 0])
        welded = np.empty(len(kept), dtype=np.int32)
        welded[order] = order[first][np.cumsum(first) - 1]
        return welded

    def _opened(
        self,
        vertices: Floats,
        triangles: Indices,
        kept: NDArray[np.int64],
        welded: Indices,
        carried: Carried,
    ) -> tuple[Floats, Indices, NDArray[np.int64], Indices, Carried, bool]:
        """Lips that are one surface are cut apart."""
        side = carried.upper["mouth"][welded]
        share = joined_share(vertices, welded[triangles], side, lip_seam(), self.skin)
        if share < _JOINED:
            return vertices, triangles, kept, welded, carried, False
        line = lip_seam().across(self.skin)
        corners = float(line.min()), float(line.max())
        triangles, welded, copied, side = cut_apart(vertices, triangles, welded, side, corners)
        told = "the lips are one surface in this mesh: cut apart along its edges"
        self.notes.append(Note("note", f"{told}, vertices added: {len(copied)}"))
        vertices = np.concatenate([vertices, vertices[copied]])
        kept = np.concatenate([kept, kept[copied]])
        carried = carry_over(self.space, self.skin, Surface(vertices, welded[triangles]), side)
        return vertices, triangles, kept, welded, carried, True

    def _without_eyes(self, vertices: Floats, triangles: Indices, welded: Indices) -> tuple[Floats, Indices]:
        """Where eye and lids are one surface, the eye is cut out: an eyeball takes its place."""
        if "eyes" not in self.added:
            return vertices, triangles
        skin = self.reshaped.face.part("skin").vertices.astype(np.float64)
        for side in self.joined_eyes:
            loop = self.space.lid_loop_left if side == "Left" else self.space.lid_loop_right
            cut = cut_out_eye(vertices, triangles, welded, skin[loop])
            vertices, triangles = cut.vertices, cut.triangles
            told = f"the {side.lower()} eye was one surface with its lids: cut out for an eyeball"
            self.notes.append(Note("note", f"{told}, faces removed: {cut.removed}"))
        return vertices, triangles

    # ------------------------------------------------------------ motion

    def _targets(self, carried: Carried, vertices: Floats, triangles: Indices) -> dict[str, Floats]:
        names = list(self.reshaped.targets)
        stack = np.hstack([self.reshaped.targets[name] for name in names])
        moved = filled(carried, carried.matrix @ stack, triangles)
        return {name: np.ascontiguousarray(moved[:, 3 * i : 3 * i + 3]) for i, name in enumerate(names)}

    def _seams(self, carried: Carried, vertices: Floats, triangles: Indices) -> dict[str, Seam]:
        """The default's lips and lids as points of the head."""
        seams = {}
        for key, own in (("mouth", lip_seam()), ("eye_left", lid_seam("Left")), ("eye_right", lid_seam("Right"))):
            side = carried.upper[key]
            halves = []
            for sign, chosen in ((1, own.upper), (-1, own.lower)):
                among = np.asarray((side[triangles] * sign > 0).all(axis=1))
                if not among.any():
                    break
                normals = Surface(self.skin, self.space.triangles).normals
                found = Surface(vertices, triangles, among).closest(chosen @ self.skin, chosen @ normals)
                halves.append(found.matrix(triangles, len(vertices)))
            if len(halves) == 2:
                pulls = (carried.matrix @ own.upper_pull, carried.matrix @ own.lower_pull)
                up, low = (pull * (side * sign >= 0) for pull, sign in zip(pulls, (1, -1), strict=True))
                seams[key] = Seam(halves[0], halves[1], up, low)
        return seams

    def _mend(self, targets: dict[str, Floats], vertices: Floats, seams: Mapping[str, Seam]) -> tuple[float, float]:
        """Close lips and lids on the head itself; returns the widest gaps left (NaN where there is no such edge)."""
        lip_gap = lid_gap = float("nan")
        if "mouth" in seams:
            lips = seams["mouth"]
            together = vertices + targets["jawOpen"] + targets["mouthClose"]
            rest = lips.gaps(vertices)
            targets["mouthClose"] += lips.closing(together, rest)
            left = lips.gaps(vertices + targets["jawOpen"] + targets["mouthClose"]) - rest
            lip_gap = float(np.percentile(left, 98))
        for side in ("Left", "Right"):
            lids = seams.get(f"eye_{side.lower()}")
            if lids is None:
                continue
            blink = f"eyeBlink{side}"
            own = lid_seam(side)
            wanted = own.gaps(self.skin + self.reshaped.targets[blink])
            targets[blink] += lids.closing(vertices + targets[blink], wanted)
            gap = float(np.percentile(lids.gaps(vertices + targets[blink]), 95))
            lid_gap = gap if np.isnan(lid_gap) else max(gap, lid_gap)
        return lip_gap, max(lid_gap, 0.0) if not np.isnan(lid_gap) else lid_gap

    # ------------------------------------------------------------ parts

    def _skin_part(
        self,
        vertices: Floats,
        triangles: Indices,
        kept: NDArray[np.int64],
        carried: Carried,
        targets: Mapping[str, Floats],
    ) -> Part:
        found = {name: sparse_target(offsets) for name, offsets in targets.items()}
        colours, material = self._paint(kept, carried)
        return Part(
            "skin",
            vertices.astype(np.float32),
            triangles,
            self.mesh.uv[self.head.kept[kept]].astype(np.float32),
            colours.astype(np.float32),
            material,
            self._head_weight(vertices),
            {name: target for name, target in found.items() if target is not None},
        )

    def _paint(self, kept: NDArray[np.int64], carried: Carried) -> tuple[Floats, Material]:
        """The mesh's own texture or colours; else the default's paint, carried over vertex by vertex."""
        own = self.mesh.colours[self.head.kept[kept]]
        material = self.space.skin.material
        if self.mesh.texture is not None:
            return own, replace(material, texture=self.mesh.texture)
        if not np.all(own == 1.0):
            return own, replace(material, texture=None)
        assert material.texture is not None
        height, width = material.texture.shape[:2]
        column = np.clip((self.space.skin.uv[:, 0] * width).astype(int), 0, width - 1)
        row = np.clip((self.space.skin.uv[:, 1] * height).astype(int), 0, height - 1)
        paint = material.texture[row, column] / 255 * self.space.skin.colours
        # Far from the fitted skin there is no place to take a colour from: the mean of the cheeks.
        usual = paint[[self.space.face.sites[f"cheek_{side}"][1] for side in ("left", "right")]].mean(0)
        share = np.clip(2 - np.nan_to_num(carried.distance, nan=99.0) / 15.0, 0, 1)[:, None]
        return usual + share * (carried.matrix @ paint - usual), replace(material, texture=None)

    def _head_weight(self, vertices: Floats) -> NDArray[np.float32]:
        """1 on what turns with the head, by the nearest of the default's skin and shirt."""
        parts = [self.reshaped.face.part(name) for name in ("skin", "shirt")]
        points = np.concatenate([part.vertices for part in parts])
        weight = np.concatenate([part.head_weight for part in parts])
        away, near = cKDTree(points).query(vertices, k=6)
        share = 1 / np.maximum(away, 1.0)
        return np.asarray((weight[near] * share).sum(1) / share.sum(1), dtype=np.float32)

    def _other_parts(self, cut: bool, carried: Carried) -> tuple[tuple[Part, ...], tuple[Eye, ...]]:
        own = self.reshaped.face
        parts: list[Part] = []
        eyes: list[Eye] = []
        lent = {part: key for key, names in _PARTS.items() if key in self.added for part in names}
        kinds = {piece.kind for piece in self.head.pieces}
        if self.eye_pieces:
            lent.pop("caruncles", None)
        for eye in own.eyes:
            piece = self.eye_pieces.get(eye.side)
            if piece is not None and not self._painted(piece) and eye.part in lent:
                eyes.append(eye)  # an eyeball without paint is replaced by a painted one of its size, in its place
            elif piece is not None:
                parts.append(self._piece_part(eye.part, [piece], Material("eye", (0.93, 0.9, 0.88), None, 0.1, 0.8)))
                centre = tuple(float(c) for c in piece.centre)
                eyes.append(replace(eye, centre=centre))  # type: ignore[arg-type]
                lent.pop(eye.part, None)
            elif eye.part in lent:
                eyes.append(eye)
        if kinds & {"upper", "lower"}:
            for part_name in ("teeth_upper", "teeth_lower", "tongue"):
                lent.pop(part_name, None)
        parts += [own.part(part_name) for part_name in lent]
        parts += self._own_pieces()
        if "mouth" in self.added and (cut or self._shallow(carried)):
            parts.append(self._piece_of_skin("mouth", self.space.inside_mouth > 0.3))
        if "eyes" in self.added and self.joined_eyes:
            side = np.where(self.space.rest[:, 0] > 0, "Left", "Right")
            behind = (self.space.socket > 0.2) & np.isin(side, self.joined_eyes)
            parts.append(self._piece_of_skin("lid_backs", behind))
        return tuple(parts), tuple(eyes)

    def _painted(self, piece: Piece) -> bool:
        numbers = self.head.kept[np.unique(self.head.triangles[piece.triangles])]
        return self.mesh.texture is not None or not bool(np.all(self.mesh.colours[numbers] == 1.0))

    def _piece_part(self, name: str, pieces: list[Piece], material: Material) -> Part:
        triangles = self.head.triangles[np.concatenate([piece.triangles for piece in pieces])]
        used, local = np.unique(triangles, return_inverse=True)
        vertices = self.head.vertices[used]
        numbers = self.head.kept[used]
        colours = self.mesh.colours[numbers]
        if self.mesh.texture is not None:
            material = replace(material, colour=(1.0, 1.0, 1.0), texture=self.mesh.texture)
        elif not np.all(colours == 1.0):
            material = replace(material, colour=(1.0, 1.0, 1.0))
        return Part(
            name,
            vertices.astype(np.float32),
            local.reshape(-1, 3).astype(np.int32),
            self.mesh.uv[numbers].astype(np.float32),
            colours.astype(np.float32),
            material,
            self._head_weight(vertices),
        )

    def _own_pieces(self) -> list[Part]:
        """Teeth that the head has of its own, rigid or on the jaw; and what follows the skin beside it."""
        parts = []
        jaw = self.reshaped.face.part("teeth_lower")
        teeth = Material("teeth", (0.9, 0.87, 0.8), None, 0.25, 0.5)
        for kind, name in (("upper", "own_upper"), ("lower", "own_lower")):
            pieces = [piece for piece in self.head.pieces if piece.kind == kind]
            if not pieces:
                continue
            part = self._piece_part(name, pieces, teeth)
            if kind == "lower":
                part = replace(part, head_weight=np.ones(len(part.vertices), np.float32), targets=_as_jaw(jaw, part))
            parts.append(replace(part, head_weight=np.ones(len(part.vertices), np.float32)))
        others = [piece for piece in self.head.pieces if piece.kind == "other"]
        if others:
            part = self._piece_part("other", others, Material("other", (0.45, 0.38, 0.33), None, 0.8, 0.1))
            parts.append(replace(part, targets=self._following(part)))
        return parts

    def _following(self, part: Part) -> dict[str, Target]:
        """Hair, brows, collars: what lies close to the skin moves with it."""
        away, near = cKDTree(self.skin).query(part.vertices)
        share = np.clip(2 - away / (_FOLLOWERS_MM / 2), 0, 1)[:, None]
        found = {name: sparse_target(offsets[near] * share) for name, offsets in self.reshaped.targets.items()}
        return {name: target for name, target in found.items() if target is not None}

    def _shallow(self, carried: Carried) -> bool:
        """Whether the head has no inside of the mouth worth the name."""
        inside = carried.matrix @ self.space.inside_mouth
        there = (inside > 0.5) & (carried.distance < 12.0)
        if there.sum() < 8:
            return True
        depth = carried.matrix @ self.skin[:, 2]
        return bool(depth[there].min() > self.skin[self.space.lip_loop, 2].min() - _MOUTH_DEPTH_MM)

    def _piece_of_skin(self, name: str, vertices: NDArray[np.bool_]) -> Part:
        """A piece of the default's skin: the mouth's inside from where the lips turn inwards, the backs of lids."""
        skin = self.reshaped.face.part("skin")
        chosen = vertices[skin.triangles].all(axis=1)
        used, local = np.unique(skin.triangles[chosen], return_inverse=True)
        number = np.full(len(skin.vertices), -1)
        number[used] = np.arange(len(used))
        targets = {}
        for key, target in skin.targets.items():
            there = number[target.vertices] >= 0
            if there.any():
                moved = number[target.vertices[there]].astype(np.int32)
                targets[key] = Target(moved, target.offsets[there])
        return Part(
            name, skin.vertices[used], local.reshape(-1, 3).astype(np.int32), skin.uv[used], skin.colours[used],
            skin.material, skin.head_weight[used], targets,
        )  # fmt: skip

    def _sites(self, vertices: Floats, carried: Carried) -> dict[str, tuple[str, int]]:
        """The default's sites at the nearest vertices of the head."""
        tree = cKDTree(vertices)
        return {
            name: ("skin", int(tree.query(self.skin[vertex])[1])) for name, (_, vertex) in self.space.face.sites.items()
        }

    def _tell(self, folded: Mapping[str, float], lip_gap: float, lid_gap: float) -> None:
        if np.isnan(lip_gap):
            self.notes.append(Note("warning", "no lips that part were found: the mouth will not open"))
        elif lip_gap > 1.0:
            self.notes.append(Note("warning", f"the lips stay {lip_gap:.1f} mm apart where they should meet"))
        if np.isnan(lid_gap):
            self.notes.append(Note("warning", "no eyelids that part were found: the eyes will not shut"))
        elif lid_gap > 1.0:
            self.notes.append(Note("warning", f"the lids stay {lid_gap:.1f} mm apart in a blink"))
        bare = [side.lower() for side, piece in self.eye_pieces.items() if not self._painted(piece)]
        if bare and "eyes" in self.added:
            self.notes.append(Note("note", f"eyeballs without paint replaced by painted ones: {' and '.join(bare)}"))
        for side in self.joined_eyes if "eyes" not in self.added else ():
            told = f"the {side.lower()} eye is one surface with its lids: it cannot turn, and a blink draws it along"
            self.notes.append(Note("warning", told))
        if folded:
            worst = max(folded, key=lambda each: folded[each])
            most = f"most {worst} ({100 * folded[worst]:.1f} % of it)"
            told = f"shapes that turn some of the skin over: {len(folded)}, {most}"
            self.notes.append(Note("warning", told))
        if not any(name in self.reshaped.targets for name in ARKIT):
            raise InputError("the default face has no shapes to transfer")

    def _lids_joined(self, key: str) -> bool:
        """Whether the mesh leads from lid to lid across the eye: a surface that looks forward fills the opening."""
        side = key[4:].capitalize()
        loop = self.skin[self.space.lid_loop_left if side == "Left" else self.space.lid_loop_right]
        middle, half = (loop.max(0) + loop.min(0)) / 2, np.ptp(loop, axis=0) / 2
        small = middle + (loop - middle) * np.array([0.6, 0.6, 1.0])
        triangles = self.head.triangles[self.head.of("skin")]
        patch = eye_patch(self.head.vertices, triangles, small)
        corner = self.head.vertices[triangles[patch]]
        area = np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1).sum() / 2
        return bool(area > _EYE_FILLED * np.pi * (0.6 * half[0]) * (0.6 * half[1]))


def _shared(carried: Carried, welded: Indices) -> Carried:
    """What the stand-ins carry, for all that they stand for."""
    return Carried(
        carried.matrix[welded], carried.trust[welded], carried.distance[welded],
        {name: side[welded] for name, side in carried.upper.items()},
    )  # fmt: skip


def _as_jaw(jaw: Part, part: Part) -> dict[str, Target]:
    """The motion of the default's lower teeth on another row: rigid, so an affine fit of each target says it."""
    middle = jaw.vertices.mean(0)
    arm = np.hstack([(jaw.vertices - middle) / 10.0, np.ones((len(jaw.vertices), 1))])
    own = np.hstack([(part.vertices - middle) / 10.0, np.ones((len(part.vertices), 1))])
    found = {}
    for name, target in jaw.targets.items():
        offsets = np.zeros((len(jaw.vertices), 3))
        offsets[target.vertices] = target.offsets
        moved = sparse_target(own @ np.linalg.lstsq(arm, offsets, rcond=None)[0])
        if moved is not None:
            found[name] = moved
    return found


def _folded(vertices: Floats, triangles: Indices, targets: Mapping[str, Floats]) -> dict[str, float]:
    """Share of the skin's area that each target at weight 1 turns over, where it is more than on the default face."""
    space = head_space()
    own = _turned_over(space.rest, space.triangles, dense_targets(space))
    found = _turned_over(vertices, triangles, targets)
    return {name: share for name, share in found.items() if share > own.get(name, 0.0) + _FOLDED}


def _turned_over(vertices: Floats, triangles: Indices, targets: Mapping[str, Floats]) -> dict[str, float]:
    def facing(points: Floats) -> Floats:
        corner = points[triangles]
        return np.asarray(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]))

    rest = facing(vertices)
    area = np.linalg.norm(rest, axis=1)
    shares = {}
    for name, offsets in targets.items():
        posed = facing(vertices + offsets)
        size = np.linalg.norm(posed, axis=1)
        turned = ((rest * posed).sum(1) < -0.2 * area * size) & (size > 0.05 * area)
        shares[name] = float(area[turned].sum() / area.sum())
    return shares
