"""How the loose pieces of a head move.

Teeth go rigidly with the jaw or not at all, gums between them, eyeballs turn about their centres, lashes go by their
roots, and what lies on the skin with the skin.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from mien.face.head_reshaping import SMALLEST_MOVE
from mien.face.model import Face, Part, Target
from mien.face.posing import eye_rotation
from mien.face.surface import vertex_normals
from mien.face.warps import Similarity, similarity_between
from mien.fit.head_mesh import HeadMesh
from mien.fit.piece_kinds import Piece
from mien.fit.shape_transfer import filled

__all__ = ["PieceMotion"]

Floats = NDArray[np.float64]
Indices = NDArray[np.int32]

_FOLLOWERS_MM = 12.0  # what lies farther than this from the skin does not move with it
_ROOT_MM, _SMALL_MM = 1.0, 90.0
_SEED_MM = 4.0
_ROOT_OF_TONGUE_MM = 5.0  # about which the gums give way to a tongue that grows out of them
_TOOTH_MM, _CROWN_MM = 6.0, 7.0  # about how thick a tooth is, and how high
_TONGUE_MM = (5.0, 20.0, 5.0)  # from the teeth's edges: up to its top, down to its root, where its back must reach
_AT_ONCE = 9  # targets
_ALONE = ("lower", "tongue", "gums", "upper", "eye_left", "eye_right")  # kinds that follow no skin
_OF_JAW = ("jawOpen", "jawForward", "jawLeft", "jawRight")


class PieceMotion:
    """Targets of the pieces of one head.

    Parameters
    ----------
    head : HeadMesh
    own : Face
        The default face on this head: its teeth and tongue show how the jaw moves.
    skin : ndarray, shape (n, 3)
        The head's skin, mm.
    moves : mapping of str to ndarray of shape (n, 3)
        Its targets.
    """

    def __init__(self, head: HeadMesh, own: Face, skin: Floats, moves: Mapping[str, NDArray[np.floating[Any]]]) -> None:
        self.head, self.own, self.skin, self.moves = head, own, skin, moves
        self._jaw = _rigid_moves(own.part("teeth_lower"))

    def of(self, pieces: Sequence[Piece]) -> dict[str, Target]:
        """Targets of some pieces together, on their vertices in the order of their numbers."""
        used = np.unique(self.head.triangles[np.concatenate([piece.triangles for piece in pieces])])
        found: dict[str, list[Target]] = {}
        for piece in pieces:
            if piece.kind in _ALONE:
                place = np.searchsorted(used, np.unique(self.head.triangles[piece.triangles]))
                for name, target in self._targets(piece).items():
                    found.setdefault(name, []).append(Target(place[target.vertices].astype(np.int32), target.offsets))
        followers = [piece for piece in pieces if piece.kind not in _ALONE]
        for name, target in self._following(followers, used) if followers else ():
            found.setdefault(name, []).append(target)
        return {name: _together(some) for name, some in found.items()}

    def _targets(self, piece: Piece) -> dict[str, Target]:
        triangles = self.head.triangles[piece.triangles]
        used = np.unique(triangles)
        points = self.head.vertices[used]
        if piece.kind in ("lower", "tongue"):
            found = {name: move(points) - points for name, move in self._jaw.items()}
            if piece.kind == "tongue":
                found |= self._of_tongue(points)
        elif piece.kind == "gums":
            share = self._jaw_share(used, triangles, points)[:, None]
            found = {name: share * (move(points) - points) for name, move in self._jaw.items()}
            local = self._joined(used, triangles)
            lobe = self._lobe(points, local)
            if lobe is not None:
                held = lobe | (cKDTree(points[lobe]).query(points)[0] > _ROOT_OF_TONGUE_MM)
                smooth = filled(held.astype(np.float64), lobe[:, None].astype(np.float64), local)
                for name, offsets in self._of_tongue(points, lobe).items():
                    found[name] = smooth * offsets
        elif piece.kind.startswith("eye_"):
            found = self._looking(piece, points)
        else:  # upper teeth
            found = {}
        kept = ((name, _sparse(offsets)) for name, offsets in found.items())
        return {name: target for name, target in kept if target is not None}

    def tongue_in(self, piece: Piece) -> bool:
        """Whether a tongue is one piece with these gums."""
        triangles = self.head.triangles[piece.triangles]
        used = np.unique(triangles)
        return self._lobe(self.head.vertices[used], self._joined(used, triangles)) is not None

    def _lobe(self, points: Floats, triangles: Indices) -> NDArray[np.bool_] | None:
        """Which points of gums are a tongue's; None if there is none.

        A tongue rises between the lower teeth about as high as their edges and bulges, where gums and palate are
        hollow.
        """
        teeth = self._lower_teeth()
        edge = float(np.percentile(teeth[:, 1], 95))
        teeth = teeth[teeth[:, 1] > edge - _CROWN_MM]
        front = float(np.percentile(teeth[:, 2], 98)) - _TOOTH_MM
        depth = np.linspace(teeth[:, 2].min(), front, 24)
        beside = [np.abs(teeth[np.abs(teeth[:, 2] - place) < _TOOTH_MM / 2, 0]) for place in depth]
        inner = np.array([np.percentile(some, 5) if len(some) else np.nan for some in beside])
        inner = np.interp(depth, depth[~np.isnan(inner)], inner[~np.isnan(inner)])
        axis = np.array([float(teeth[:, 0].max() + teeth[:, 0].min()) / 2, edge - _TONGUE_MM[1] / 2, 0.0])
        arm = points - axis
        arm[:, 2] = np.maximum(points[:, 2] - front + _TONGUE_MM[1] / 2, 0.0)
        facing = vertex_normals(points, triangles)
        above = (np.abs(arm[:, 0]) < 8.0) & (points[:, 1] > edge + _TONGUE_MM[0]) & (points[:, 2] < front)
        if above.any() and facing[above, 1].mean() > 0:  # a palate looks down
            facing = -facing
        lobe = (np.abs(arm[:, 0]) < np.interp(points[:, 2], depth, inner)) & (points[:, 2] < front)
        lobe &= (points[:, 1] < edge + _TONGUE_MM[0]) & (points[:, 1] > edge - _TONGUE_MM[1])
        lobe &= np.einsum("nd,nd->n", facing, arm) > 0.3 * np.linalg.norm(arm, axis=1)
        risen = lobe & (points[:, 1] > edge - _TONGUE_MM[2])
        return lobe if risen.sum() >= 6 else None

    def _lower_teeth(self) -> Floats:
        numbers = [piece.triangles for piece in self.head.pieces if piece.kind == "lower"]
        if numbers:
            return self.head.vertices[np.unique(self.head.triangles[np.concatenate(numbers)])]
        return np.asarray(self.own.part("teeth_lower").vertices, dtype=np.float64)

    def _jaw_share(self, used: Indices, triangles: Indices, points: Floats) -> Floats:
        """1 on what moves with the jaw, 0 on what stays, smooth between: told by the teeth that stand in it."""
        known = np.full(len(points), np.nan)
        for kind, share in (("upper", 0.0), ("lower", 1.0)):
            numbers = [piece.triangles for piece in self.head.pieces if piece.kind == kind]
            if numbers:
                teeth = self.head.vertices[np.unique(self.head.triangles[np.concatenate(numbers)])]
                known[cKDTree(teeth).query(points)[0] < _SEED_MM] = share
        if np.isnan(known).all():
            border = self.own.part("teeth_lower").vertices[:, 1].max()
            known = np.where(points[:, 1] > border + 2, 0.0, np.where(points[:, 1] < border - 2, 1.0, np.nan))
        trust = np.where(np.isnan(known), 0.0, 1.0)
        return np.clip(filled(trust, np.nan_to_num(known)[:, None], self._joined(used, triangles))[:, 0], 0, 1)

    def _joined(self, used: Indices, triangles: Indices) -> Indices:
        """Triangles by place among the used vertices, those that lie together taken as one."""
        joined = np.searchsorted(used, self.head.welded[triangles])
        inside = np.asarray(
            (joined < len(used)) & (used[np.minimum(joined, len(used) - 1)] == self.head.welded[triangles])
        )
        return np.where(inside, joined, np.searchsorted(used, triangles)).astype(np.int32)

    def _of_tongue(self, points: Floats, lobe: NDArray[np.bool_] | None = None) -> dict[str, Floats]:
        """The default tongue's own shapes, laid box on box; ``lobe`` (n,) are the points that fill the box."""
        part = self.own.part("tongue")
        low, size = part.vertices.min(0), np.ptp(part.vertices, axis=0)
        inside = points if lobe is None else points[lobe]
        extent = np.maximum(np.ptp(inside, axis=0), 1e-6)
        placed = (points - inside.min(0)) / extent * size + low
        away, near = cKDTree(part.vertices).query(placed, k=6)
        share = 1 / np.maximum(away, 0.3) ** 2
        share /= share.sum(axis=1, keepdims=True)
        stretch = extent / size
        return {
            name: (share[:, :, None] * _dense(target, len(part.vertices))[near]).sum(axis=1) * stretch
            for name, target in part.targets.items()
            if name not in _OF_JAW
        }

    def _looking(self, piece: Piece, points: Floats) -> dict[str, Floats]:
        """An eyeball turned about its centre: for files in which it is no node of its own."""
        side = piece.kind[4:].capitalize()
        eye = next(eye for eye in self.own.eyes if eye.side == side)
        found = {}
        for number, way in enumerate(("Up", "Down", "In", "Out")):
            weights = [float(number == k) for k in range(4)]
            arm = points - piece.centre
            found[f"eyeLook{way}{side}"] = arm @ eye_rotation(eye, *weights).T - arm
        return found

    def _following(self, pieces: Sequence[Piece], used: Indices) -> Iterator[tuple[str, Target]]:
        """What lies on the skin moves with it: lashes from their roots, hair and collars as far as they are near."""
        count = len(used)
        share, rooted = np.zeros(count), np.zeros(count, dtype=np.bool_)
        local = [np.searchsorted(used, self.head.triangles[piece.triangles]).astype(np.int32) for piece in pieces]
        mine = np.unique(np.concatenate(local))
        away, near = np.full(count, np.inf), np.zeros(count, dtype=np.int64)
        away[mine], near[mine] = cKDTree(self.skin).query(self.head.vertices[used[mine]])
        for triangles in local:
            some = np.unique(triangles)
            nearest, points = float(away[some].min()), self.head.vertices[used[some]]
            if nearest < 2 * _ROOT_MM and np.linalg.norm(np.ptp(points, axis=0)) < _SMALL_MM:
                rooted[some], share[some] = True, away[some] < max(_ROOT_MM, 1.2 * nearest)
            else:
                share[some] = np.clip(2 - away[some] / (_FOLLOWERS_MM / 2), 0, 1)
        trust = np.where(rooted, share, 1.0)
        names, triangles = list(self.moves), np.concatenate(local)
        for first in range(0, len(names), _AT_ONCE):
            some_names = names[first : first + _AT_ONCE]
            values = np.hstack([self.moves[name][near] for name in some_names]).astype(np.float64)
            values = filled(trust, values * np.where(rooted, 1.0, share)[:, None], triangles)
            for number, name in enumerate(some_names):
                target = _sparse(values[:, 3 * number : 3 * number + 3])
                if target is not None:
                    yield name, target


def _sparse(offsets: Floats) -> Target | None:
    moved = np.flatnonzero(np.abs(offsets).max(axis=1) >= SMALLEST_MOVE)
    return Target(moved.astype(np.int32), offsets[moved].astype(np.float32)) if len(moved) else None


def _together(targets: Sequence[Target]) -> Target:
    numbers = np.concatenate([target.vertices for target in targets])
    numbers, first = np.unique(numbers, return_index=True)
    return Target(numbers, np.concatenate([target.offsets for target in targets])[first])


def _dense(target: Target, count: int) -> Floats:
    offsets = np.zeros((count, 3))
    offsets[target.vertices] = target.offsets
    return offsets


def _rigid_moves(teeth: Part) -> dict[str, Similarity]:
    """The rigid motion of the default's lower teeth in each target that moves the jaw."""
    rest = teeth.vertices.astype(np.float64)
    return {
        name: similarity_between(rest, rest + _dense(target, len(rest)), scaled=False)
        for name, target in teeth.targets.items()
        if name in _OF_JAW
    }
