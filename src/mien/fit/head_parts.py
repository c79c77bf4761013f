"""The parts of a fitted head: its skin with paint, its own loose pieces, and what the default face lends it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from mien.face.head_reshaping import Reshaped, sparse_target
from mien.face.head_space import HeadSpace
from mien.face.model import Eye, Material, Part, Target
from mien.fit.head_mesh import HeadMesh
from mien.fit.piece_kinds import Piece
from mien.fit.piece_motion import PieceMotion
from mien.fit.shape_transfer import Carried

__all__ = ["ADDED", "DEFAULT_ADDED", "GivenMesh", "HeadParts", "Origin"]

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
_MOUTH_DEPTH_MM = 14.0
_SCALP_MM = 16.0  # from the default's hair
_OWN = {
    "upper": Material("teeth", (0.9, 0.87, 0.8), None, 0.25, 0.5),
    "lower": Material("teeth", (0.9, 0.87, 0.8), None, 0.25, 0.5),
    "gums": Material("gums", (0.62, 0.3, 0.3), None, 0.35, 0.4),
    "tongue": Material("tongue", (0.66, 0.33, 0.33), None, 0.4, 0.4),
    "lash": Material("lashes", (0.1, 0.08, 0.07), None, 0.8, 0.1),
    "other": Material("other", (0.2, 0.15, 0.12), None, 0.8, 0.1),
}


@dataclass(frozen=True, eq=False)
class Origin:
    """Where in a glTF file some vertices of a mesh come from.

    Attributes
    ----------
    mesh, primitive : int
    first, count : int
        Their place among the mesh's vertices.
    linear : ndarray, shape (1 or count, 3, 3)
        Brings offsets from the primitive's own coordinates to the mesh's.
    triangles : ndarray of int64, shape (t, 3)
        Of the primitive, by its own numbers.
    """

    mesh: int
    primitive: int
    first: int
    count: int
    linear: Floats
    triangles: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class GivenMesh:
    """A mesh as it came from a file; ``texture`` (height, width, 3) with ``uv`` from its upper left corner, or None."""

    vertices: Floats
    triangles: Indices
    uv: Floats
    colours: Floats
    texture: NDArray[np.uint8] | None = None
    origins: tuple[Origin, ...] = ()


@dataclass(frozen=True, eq=False)
class HeadParts:
    """Makes the parts of one head.

    Attributes
    ----------
    space : HeadSpace
    mesh : GivenMesh
    head : HeadMesh
    skin : ndarray, shape (m, 3)
        The default skin fitted to it, mm.
    reshaped : Reshaped
        The default face on that skin.
    added : tuple of str
        Of `ADDED`.
    joined_eyes : tuple of str
        Sides on which eye and lids were one surface.
    """

    space: HeadSpace
    mesh: GivenMesh
    head: HeadMesh
    skin: Floats
    reshaped: Reshaped
    added: tuple[str, ...]
    joined_eyes: tuple[str, ...]

    @property
    def eye_pieces(self) -> dict[str, Piece]:
        """The head's own eyeballs by side."""
        return {p.kind[4:].capitalize(): p for p in self.head.pieces if p.kind.startswith("eye_")}

    def unpainted_eyes(self) -> list[str]:
        """Sides of the head's own eyeballs that have no paint."""
        return [side for side, piece in self.eye_pieces.items() if not self._painted(piece)]

    @property
    def bare_lashes(self) -> bool:
        """Whether the head has lashes without paint: cards whose hairs were in a picture."""
        lashes = [piece for piece in self.head.pieces if piece.kind == "lash"]
        return bool(lashes) and not any(self._painted(piece) for piece in lashes)

    def _told(self, names: set[str], in_gums: bool, hollow: bool) -> str:
        """Of eyes, teeth, tongue and the mouth's inside: whose they are; ``names`` are the parts'."""
        kinds = [piece.kind for piece in self.head.pieces]
        joined, teeth = "of its own, one piece with the gums", sum(kind in ("upper", "lower") for kind in kinds)
        anew = ", painted anew" if self.unpainted_eyes() and "eyes" in self.added else ""
        own = {
            "eyes": f"of its own ({len(self.eye_pieces)}){anew}" if self.eye_pieces else "",
            "teeth": f"of its own, pieces: {teeth}" if teeth else joined if "gums" in kinds else "",
            "tongue": "of its own" if "tongue" in kinds else joined if in_gums else "",
            "inside of the mouth": "of its own" if hollow else "",
        }
        lent = {"eyes": "eye_left", "teeth": "teeth_lower", "tongue": "tongue", "inside of the mouth": "mouth"}
        found = {key: words or ("the default's" if lent[key] in names else "none") for key, words in own.items()}
        return "; ".join(f"{key}: {words}" for key, words in found.items())

    def skin_part(
        self,
        vertices: Floats,
        triangles: Indices,
        kept: NDArray[np.int64],
        carried: Carried,
        targets: Mapping[str, NDArray[np.floating[Any]]],
    ) -> Part:
        """The skin with its paint and its targets; ``kept`` are the head's numbers of its vertices."""
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
        if "hair" not in self.added:
            paint = self._without_scalp(paint)
        # Far from the fitted skin there is no place to take a colour from: the mean of the cheeks.
        usual = paint[[self.space.face.sites[f"cheek_{side}"][1] for side in ("left", "right")]].mean(0)
        share = np.clip(2 - np.nan_to_num(carried.distance, nan=99.0) / 15.0, 0, 1)[:, None]
        return usual + share * (carried.matrix @ paint - usual), replace(material, texture=None)

    def _without_scalp(self, paint: Floats) -> Floats:
        """The default's paint without the cropped hair on its scalp, which nobody asked for."""
        away = cKDTree(self.space.face.part("hair").vertices).query(self.space.rest)[0]
        light = paint.mean(axis=1)
        x, y, z = self.space.rest.T
        forehead = (np.abs(x) < 45) & (y > 22) & (z > 0) & (away > 6.0)
        skin = forehead & (light > 0.9 * np.median(light[forehead]))
        share = np.clip((_SCALP_MM - away) / 4.0, 0, 1) * (light < light[skin].min())
        return np.asarray(paint + share[:, None] * (np.median(paint[skin], axis=0) - paint))

    def _head_weight(self, vertices: Floats) -> NDArray[np.float32]:
        """1 on what turns with the head, by the nearest of the default's skin and shirt."""
        parts = [self.reshaped.face.part(name) for name in ("skin", "shirt")]
        points = np.concatenate([part.vertices for part in parts])
        weight = np.concatenate([part.head_weight for part in parts])
        away, near = cKDTree(points).query(vertices, k=6)
        share = 1 / np.maximum(away, 1.0)
        return np.asarray((weight[near] * share).sum(1) / share.sum(1), dtype=np.float32)

    def other_parts(
        self, cut: bool, carried: Carried, motion: PieceMotion
    ) -> tuple[tuple[Part, ...], tuple[Eye, ...], str]:
        """All but the skin: the head's own pieces and what it is lent; how its eyeballs turn; and whose is what."""
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
                pieces = [each for each in self.head.pieces if each.kind == piece.kind]
                parts.append(self._piece_part(eye.part, pieces, Material("eye", (0.93, 0.9, 0.88), None, 0.1, 0.8)))
                centre = tuple(float(c) for c in piece.centre)
                eyes.append(replace(eye, centre=centre))  # type: ignore[arg-type]
                lent.pop(eye.part, None)
            elif eye.part in lent:
                eyes.append(eye)
        if kinds & {"upper", "lower", "gums"}:
            lent.pop("teeth_upper", None)
            lent.pop("teeth_lower", None)
        in_gums = any(motion.tongue_in(piece) for piece in self.head.pieces if piece.kind == "gums")
        if "tongue" in kinds or in_gums:
            lent.pop("tongue", None)
        if self.bare_lashes:
            lent["lashes"] = "lashes"
        parts += [own.part(part_name) for part_name in lent]
        parts += self._own_pieces(motion)
        hollow = not (cut or self._shallow(carried))
        if "mouth" in self.added and not hollow:
            parts.append(self._piece_of_skin("mouth", self.space.inside_mouth > 0.3))
        if "eyes" in self.added and self.joined_eyes:
            side = np.where(self.space.rest[:, 0] > 0, "Left", "Right")
            behind = (self.space.socket > 0.2) & np.isin(side, self.joined_eyes)
            parts.append(self._piece_of_skin("lid_backs", behind))
        return tuple(parts), tuple(eyes), self._told({part.name for part in parts}, in_gums, hollow)

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

    def _own_pieces(self, motion: PieceMotion) -> list[Part]:
        """Teeth, gums and tongue that the head has of its own, and what follows the skin beside it."""
        parts = []
        for kind, material in _OWN.items():
            pieces = [piece for piece in self.head.pieces if piece.kind == kind]
            if pieces and not (kind == "lash" and self.bare_lashes):
                part = self._piece_part(f"own_{kind}" if kind != "other" else kind, pieces, material)
                part = replace(part, targets=motion.of(pieces))
                if kind != "other":
                    part = replace(part, head_weight=np.ones(len(part.vertices), np.float32))
                parts.append(part)
        return parts

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
