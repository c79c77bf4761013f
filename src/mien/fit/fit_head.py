"""A bare head mesh becomes a `Face`: the 52 ARKit shapes and mien's further ones, eyes, teeth and tongue."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from mien.core.channels import ARKIT
from mien.core.errors import InputError, Note
from mien.face.contact import Seam, dense_targets, lid_seam, lip_seam
from mien.face.head_reshaping import EyePlace, Reshaped, reshaped_face
from mien.face.head_space import HeadSpace, head_space
from mien.face.model import Face, Target
from mien.face.surface import Surface
from mien.face.warps import Similarity
from mien.fit.alignment import Alignment, align
from mien.fit.eye_cut import cut_out_eye, eye_patch
from mien.fit.eye_socket import sockets_of
from mien.fit.fit_judge import Finding, judged
from mien.fit.head_mesh import HeadMesh, outward, prepared_mesh
from mien.fit.head_parts import ADDED, DEFAULT_ADDED, GivenMesh, HeadParts
from mien.fit.head_search import find_head
from mien.fit.landmarks import needed_landmarks, places_of_landmarks
from mien.fit.lip_cut import cut_apart, joined_share
from mien.fit.piece_motion import PieceMotion
from mien.fit.shape_transfer import Carried, carry_over, filled, strays
from mien.fit.surface_fit import FitSettings, SurfaceFit, fit_surface

__all__ = ["ADDED", "FittedHead", "GivenMesh", "fit_head"]

Floats = NDArray[np.float64]
Indices = NDArray[np.int32]
Moves = NDArray[np.floating[Any]]

_FOLDED = 0.001  # of the skin's area
_EYE_FILLED = 0.4  # of the opening between the lids
_JOINED = 0.5  # of the mouth's width
_AT_ONCE = 9  # targets
_LID_OVERLAP = 0.0  # mm: lids that shut meet; the default's overlap a little


@dataclass(frozen=True, eq=False)
class FittedHead:
    """The result of `fit_head`.

    Attributes
    ----------
    face : Face
    fit : SurfaceFit
        The default skin bent onto the head, in the face's axes.
    alignment : Alignment
    lip_gap, lid_gap : float
        What is left open between the lips in ``jawOpen`` with ``mouthClose`` (over what is open at rest; 98th
        percentile along them), and between the lids of either eye in a blink (95th), mm; NaN where there are none.
    folded : mapping of str to float
        Share of the skin's area that a target at weight 1 turns over, where it is more than on the default face.
    kept : ndarray of int64
        Number in the file of each vertex of the skin's part.
    copied : int
        How many of them, the last ones, are copies made where lips were cut apart.
    loose : tuple of (ndarray of int64, mapping of str to Target)
        Of the head's other pieces: numbers of their vertices in the file, and how they move (eyeballs too).
    findings : tuple of Finding
        What is seen of it, judged.
    notes : tuple of Note
    """

    face: Face
    fit: SurfaceFit
    alignment: Alignment
    lip_gap: float
    lid_gap: float
    folded: Mapping[str, float]
    kept: NDArray[np.int64]
    copied: int
    loose: tuple[tuple[NDArray[np.int64], Mapping[str, Target]], ...]
    findings: tuple[Finding, ...]
    notes: tuple[Note, ...]


def fit_head(
    mesh: GivenMesh,
    landmarks: Mapping[str, tuple[float, ...]] | None = None,
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
    landmarks : mapping of str to 3 numbers (a place) or 1 (a vertex), optional
        As `mien.fit.landmarks.read_landmarks` reads them. What is not given of those that are needed is found.
    name : str
        Of the face.
    unit : str, optional
        One of `mien.fit.alignment.UNITS`; found from the head's size if not given.
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
    given = places_of_landmarks(landmarks or {}, mesh.vertices, where)
    found: dict[str, Floats] = {}
    if any(key not in given for key in needed_landmarks()):
        found = find_head(mesh.vertices, outward(mesh.vertices, mesh.triangles), space, where).places
        settings = settings or FitSettings(landmark_sigma=3.0, warped=False)
    alignment = align(found | given, space, where, unit)
    places = {key: alignment.to_face(place[None])[0] for key, place in (found | given).items()}
    template = alignment.template(space.rest)
    expected = {eye.side: alignment.template(np.array([eye.centre]))[0] for eye in space.face.eyes}
    set_by_hand = {key: places[key] for key in given}
    head = prepared_mesh(
        mesh.vertices,
        mesh.triangles,
        alignment.to_face,
        template,
        space.triangles,
        expected,
        places,
        set_by_hand,
        where,
    )
    surface = Surface(head.vertices, head.welded[head.triangles], head.of("skin"))
    eyes = {p.kind[4:].capitalize(): p.centre for p in head.pieces if p.kind.startswith("eye_")}
    fit = fit_surface(space, surface, places, alignment, settings, eyes)
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
        self.joined_eyes = tuple(side for side in sides if side not in known and self._lids_joined(side))
        self.parts = HeadParts(space, mesh, self.head, self.skin, self.reshaped, added, self.joined_eyes)

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
        whole = len(kept)
        vertices, triangles, kept, welded, carried, cut = self._opened(vertices, triangles, kept, welded, carried)
        carried = _shared(carried, welded)
        targets = self._targets(carried, vertices, welded[triangles])
        seams = self._seams(carried, vertices, welded[triangles])
        lip_gap, lid_gap = self._mend(targets, vertices, seams)
        part = self.parts.skin_part(vertices, triangles, kept, carried, targets)
        motion = PieceMotion(self.head, self.reshaped.face, vertices, targets)
        parts, eyes, told = self.parts.other_parts(cut, carried, motion)
        self.notes.append(Note("note", told))
        own = self.reshaped.face
        sites = self._sites(vertices, carried)
        face = Face(self.name, (part, *parts), eyes, own.head_pivot, sites, "")
        folded = _folded(vertices, triangles, targets)
        self._tell(folded, lip_gap, lid_gap)
        kept_in_file = self.head.kept[kept]
        others = [piece for piece in self.head.pieces if piece.kind != "skin"]
        numbers = np.unique(self.head.triangles[~self.head.of("skin")])
        loose = ((self.head.kept[numbers], motion.of(others)),) if others else ()
        fit = replace(self.fit, vertices=self.skin)
        return FittedHead(
            face, fit, self.alignment, lip_gap, lid_gap, folded, kept_in_file, len(kept) - whole, loose,
            judged(face, self.skin, lip_gap, lid_gap), tuple(self.notes),
        )  # fmt: skip

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

    def _targets(self, carried: Carried, vertices: Floats, triangles: Indices) -> dict[str, Moves]:
        names = list(self.reshaped.targets)
        sockets = sockets_of(self.reshaped.face, carried, vertices)
        trust = carried.trust.copy()
        for socket in sockets:
            trust[socket.numbers] = 1.0
        trust[strays(vertices, triangles, carried.matrix @ self.reshaped.targets["jawOpen"])] = 0.0
        found: dict[str, Moves] = {}
        for first in range(0, len(names), _AT_ONCE):  # a million vertices times all targets would not fit
            some = names[first : first + _AT_ONCE]
            moved = carried.matrix @ np.hstack([self.reshaped.targets[name] for name in some])
            for socket in sockets:
                socket.turn(moved)
            moved = filled(trust, moved, triangles).astype(np.float32)
            found |= {name: np.ascontiguousarray(moved[:, 3 * k : 3 * k + 3]) for k, name in enumerate(some)}
        return found

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

    def _mend(self, targets: dict[str, Moves], vertices: Floats, seams: Mapping[str, Seam]) -> tuple[float, float]:
        """Close lips and lids on the head itself; returns the widest gaps left (NaN where there is no such edge)."""
        lip_gap = lid_gap = float("nan")
        if "mouth" in seams:
            lips = seams["mouth"]
            together = vertices + targets["jawOpen"] + targets["mouthClose"]
            rest = lips.gaps(vertices)
            closed = lips.closing(together, rest)
            targets["mouthClose"] += closed + lips.pinching(together + closed, rest)
            left = lips.gaps(vertices + targets["jawOpen"] + targets["mouthClose"]) - rest
            lip_gap = float(np.percentile(left, 98))
        for side in ("Left", "Right"):
            lids = seams.get(f"eye_{side.lower()}")
            if lids is None:
                continue
            blink = f"eyeBlink{side}"
            own = lid_seam(side)
            wanted = np.maximum(own.gaps(self.skin + self.reshaped.targets[blink]), _LID_OVERLAP)
            closed = lids.closing(vertices + targets[blink], wanted)
            targets[blink] += closed + lids.pinching(vertices + targets[blink] + closed, wanted)
            gap = float(np.percentile(lids.gaps(vertices + targets[blink]), 95))
            lid_gap = gap if np.isnan(lid_gap) else max(gap, lid_gap)
        return lip_gap, max(lid_gap, 0.0) if not np.isnan(lid_gap) else lid_gap

    def _sites(self, vertices: Floats, carried: Carried) -> dict[str, tuple[str, int]]:
        """The default's sites at the nearest vertices of the head."""
        tree = cKDTree(vertices)
        return {
            name: ("skin", int(tree.query(self.skin[vertex])[1])) for name, (_, vertex) in self.space.face.sites.items()
        }

    def _tell(self, folded: Mapping[str, float], lip_gap: float, lid_gap: float) -> None:
        if np.isnan(lip_gap):
            self.notes.append(Note("warning", "no lips that can open were found: the mouth will not open"))
        if np.isnan(lid_gap):
            self.notes.append(Note("warning", "no eyelids that can close were found: the eyes will not shut"))
        bare = [side.lower() for side in self.parts.unpainted_eyes()]
        if bare and "eyes" in self.added:
            self.notes.append(Note("note", f"eyeballs without paint replaced by painted ones: {' and '.join(bare)}"))
        shells = sum(piece.kind == "shell" for piece in self.head.pieces)
        if shells:
            self.notes.append(
                Note("note", f"pieces over the eyeballs (tear lines, shells) left out, they hide the eyes: {shells}")
            )
        if self.parts.bare_lashes:
            self.notes.append(Note("note", "lashes without paint replaced by the default's"))
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

    def _lids_joined(self, side: str) -> bool:
        """Whether the mesh leads from lid to lid across the eye: a surface that looks forward fills the opening."""
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


def _folded(vertices: Floats, triangles: Indices, targets: Mapping[str, Moves]) -> dict[str, float]:
    """Share of the skin's area that each target at weight 1 turns over, where it is more than on the default face."""
    space = head_space()
    own = _turned_over(space.rest, space.triangles, dense_targets(space))
    found = _turned_over(vertices, triangles, targets)
    return {name: share for name, share in found.items() if share > own.get(name, 0.0) + _FOLDED}


def _turned_over(vertices: Floats, triangles: Indices, targets: Mapping[str, Moves]) -> dict[str, float]:
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
