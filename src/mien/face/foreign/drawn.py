"""A foreign face as a `mien.face.model.Face`: for the renderer, and for whatever else wants meshes.

The scene is taken at rest, skins and nodes applied, and brought to mien's axes: millimetres, looking along +z, the
origin between the eyes. Its morph targets keep their own names (`DrawnFace.track` says how they move); the head turns
and the eyes turn where the file has nodes for them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.channels import HEAD
from mien.core.errors import InputError
from mien.core.tracks import ChannelTrack
from mien.face.foreign.accessors import AccessorReader
from mien.face.foreign.draco import draco_missing, uses_draco
from mien.face.foreign.materials import Surface, SurfaceReader
from mien.face.foreign.primitives import Piece, pieces_of_node
from mien.face.foreign.recognition import ForeignFace
from mien.face.foreign.rig_nodes import lowered_arms, world_matrices
from mien.face.model import Eye, Face, Part, Target

__all__ = ["DrawnFace", "drawn_face", "not_drawn"]

Floats = NDArray[np.float64]
_EYES_APART_MM, _MOVED_MM = 63.0, 150.0
"""Between the eyes of an adult, and from brows to chin: what a file of unknown units is scaled to."""
_METRES, _HEAD, _BODY = (40.0, 110.0), (0.1, 0.6), (0.9, 2.6)
"""Eyes apart in mm, and heights in m, for which a file is taken to be in metres, as glTF says it should."""
_CHIN, _RAMP = -125.0, 40.0
_LEAST = 5e-3  # mm
_FARTHEST = 1e7  # mm: the numbers of a damaged file
_TRUNK = 0.021
_LOOKS = ("Up", "Down", "In", "Out")


@dataclass(frozen=True)
class DrawnFace:
    """A foreign face laid out.

    Attributes
    ----------
    face : Face
        Its targets are named ``mesh/target`` by number.
    foreign : ForeignFace
    notes : tuple of str
        What is not drawn as the file has it.
    origins : tuple of (int, int)
        Of each part, the numbers of its mesh in the file and of its primitive in that.
    """

    face: Face
    foreign: ForeignFace
    notes: tuple[str, ...]
    origins: tuple[tuple[int, int], ...]

    def track(self, channels: ChannelTrack) -> ChannelTrack:
        """Weights of its targets, and turns of head and eyes, from mien's channels."""
        names: list[str] = []
        columns: list[Floats] = []
        used = {name for part in self.face.parts for name in part.targets}
        for mesh in self.foreign.meshes:
            if mesh.moves:
                weights = self.foreign.weights(mesh, channels)
                for place, target in enumerate(mesh.targets):
                    if target.drives and f"{mesh.number}/{place}" in used:
                        names.append(f"{mesh.number}/{place}")
                        columns.append(weights[:, place])
        for name in sorted(used):
            if name.startswith("jaw/"):
                names.append(name)
                columns.append(np.clip(channels.select([name[4:]]).values[:, 0], 0.0, 1.0))
        turning = [f"eyeLook{way}{eye.side}" for eye in {e.side: e for e in self.face.eyes}.values() for way in _LOOKS]
        turning += HEAD if "head" in self.foreign.turning.nodes else ()
        values = np.column_stack([*columns, channels.select(turning).values]) if turning else np.column_stack(columns)
        return ChannelTrack((*names, *turning), values, channels.rate)

    def by_channels(self) -> Face:
        """The face with targets named by channels, as what solves for channels wants it.

        A channel's target is the sum of what it adds to the file's targets; what a sum takes away, and that it is held
        in 0..1, is not in it.
        """
        shares: dict[str, dict[str, float]] = {}
        for mesh in self.foreign.meshes:
            for place, target in enumerate(mesh.targets):
                for drive in target.drives:
                    for channel, weight in drive.match.recipe.items():
                        if weight > 0:
                            into = shares.setdefault(channel, {})
                            name = f"{mesh.number}/{place}"
                            into[name] = into.get(name, 0.0) + weight * drive.share
        for name in {name for part in self.face.parts for name in part.targets if name.startswith("jaw/")}:
            shares.setdefault(name[4:], {})[name] = 1.0
        parts = []
        for part in self.face.parts:
            targets = {channel: _summed(part, names) for channel, names in shares.items()}
            parts.append(
                replace(part, targets={name: target for name, target in targets.items() if len(target.vertices)})
            )
        return replace(self.face, parts=tuple(parts))


def _summed(part: Part, shares: Mapping[str, float]) -> Target:
    dense = np.zeros((len(part.vertices), 3), dtype=np.float32)
    for name, share in shares.items():
        if name in part.targets:
            dense[part.targets[name].vertices] += np.float32(share) * part.targets[name].offsets
    rows = np.flatnonzero(dense.any(axis=1))
    return Target(rows.astype(np.int32), dense[rows])


def not_drawn(foreign: ForeignFace) -> str:
    """Why a face cannot be drawn, as far as that can be said without decoding it; "" if nothing speaks against it."""
    if uses_draco(foreign.document) and draco_missing():
        return f"its meshes are compressed with Draco (driving it works): {draco_missing()}"
    return "" if any("mesh" in node for node in foreign.document.list_of("nodes")) else "it has no node with a mesh"


def drawn_face(foreign: ForeignFace, *, pictures: bool = True) -> DrawnFace:
    """Lay a foreign face out, without its textures where only its shape is wanted (``pictures`` False).

    Raises
    ------
    InputError
        If it cannot be drawn: compressed in a way that mien does not decode, damaged, or without a mesh.
    """
    document = foreign.document
    reason = not_drawn(foreign)
    if reason:
        raise InputError(f"{document.path} cannot be drawn: {reason}")
    reader, surfaces = AccessorReader(document), SurfaceReader(document, pictures)
    arms = lowered_arms(document, foreign.turning.nodes) if foreign.arms else {}
    world = world_matrices(document, arms)
    try:
        pieces = [p for node in _shown(foreign) for p in pieces_of_node(foreign, node, world, reader, surfaces)]
    except (KeyError, IndexError, TypeError, AttributeError, ValueError) as problem:
        raise InputError(f"{document.path} cannot be drawn: its meshes do not hold together ({problem!r})") from problem
    if not pieces:
        raise InputError(f"{document.path} cannot be drawn: no node of its scene shows triangles")
    placed = _placing(foreign, pieces, world)
    parts, eyes = [], []
    for number, piece in enumerate(pieces):
        part = _part(piece, f"{number} {piece.name}", placed, "head" in foreign.turning.nodes)
        parts.append(part)
        if piece.eye:
            node = foreign.turning.nodes[f"eye{piece.eye}"]
            centre = placed.points(world[node][None, :3, 3])[0]
            degrees = [foreign.turning.degrees[way] for way in _LOOKS]
            eyes.append(Eye(part.name, piece.eye, (centre[0], centre[1], centre[2]), *degrees))
    name = document.path.stem
    pivot = (0.0, -110.0, -60.0)
    if "head" in foreign.turning.nodes:
        point = placed.points(world[foreign.turning.nodes["head"]][None, :3, 3])[0]
        pivot = (float(point[0]), float(point[1]), float(point[2]))
    asset = document.json.get("asset")
    licence = str(asset.get("copyright", "")) if isinstance(asset, dict) else ""
    face = Face(name, tuple(parts), tuple(eyes), pivot, {}, licence)
    notes = tuple(dict.fromkeys(surfaces.faults))
    return DrawnFace(face, foreign, notes, tuple(piece.origin for piece in pieces))


def _shown(foreign: ForeignFace) -> list[int]:
    """Nodes with a mesh in the scene that is shown, or anywhere where the file has no scene."""
    document = foreign.document
    scenes, nodes = document.list_of("scenes"), document.list_of("nodes")
    number = document.json.get("scene", 0)
    roots: Sequence[int] = range(len(nodes))
    if scenes:
        roots = scenes[number if isinstance(number, int) and 0 <= number < len(scenes) else 0].get("nodes", [])
    found = dict.fromkeys(node for root in roots for node in document.below(root))
    return [node for node in found if "mesh" in nodes[node]]


@dataclass(frozen=True)
class _Placing:
    """From the file's axes to mien's."""

    origin: Floats
    scale: float
    facing: int

    def points(self, points: Floats) -> Floats:
        return self.offsets(points - self.origin)

    def offsets(self, offsets: NDArray[np.floating[Any]]) -> Floats:
        return np.asarray(offsets * self.scale * np.array([self.facing, 1.0, self.facing]))


def _placing(foreign: ForeignFace, pieces: Sequence[Piece], world: Floats) -> _Placing:
    nodes, facing = foreign.turning.nodes, foreign.turning.facing
    moved = _moved(pieces)
    height = float(np.ptp(moved[:, 1]))
    scale = _scale(height, pieces)
    eyes = None
    if {"eyeLeft", "eyeRight"} <= set(nodes):
        eyes = world[[nodes["eyeLeft"], nodes["eyeRight"]], :3, 3]
        apart = 1000.0 * float(np.linalg.norm(eyes[0] - eyes[1]))
        if not 100.0 * height < apart < 2000.0 * height:
            eyes = None
        else:
            scale = 1000.0 if _METRES[0] < apart < _METRES[1] else 1000.0 * _EYES_APART_MM / apart
    if eyes is not None:
        return _Placing(eyes.mean(axis=0), scale, facing)
    low, high = moved.min(axis=0), moved.max(axis=0)
    blinks = _blinking(foreign, pieces)
    origin = blinks.mean(axis=0) if len(blinks) else np.array([0.5 * (low[0] + high[0]), high[1] - 0.3 * height, 0.0])
    whole = np.concatenate([piece.vertices[:, 1] for piece in pieces if piece.targets] or [moved[:, 1]])
    if not len(blinks) and 2.2 * height < np.ptp(whole) < 400.0 / scale:  # little moves of a head: eyes lie half-way up
        origin[1] = 0.5 * (whole.min() + whole.max())
    front = high[2] if facing > 0 else low[2]
    origin[2] = front - facing * 30.0 / scale
    return _Placing(origin, scale, facing)


def _scale(moved_height: float, pieces: Sequence[Piece]) -> float:
    """Millimetres in a unit of the file, told without eyes: by the meshes that move, else by what moves of them."""
    heights = np.concatenate([piece.vertices[:, 1] for piece in pieces if piece.targets] or [np.zeros(1)])
    height = float(np.ptp(heights))
    if _HEAD[0] < height < _HEAD[1] or _BODY[0] < height < _BODY[1]:
        return 1000.0
    return _MOVED_MM / moved_height if moved_height > 0 else 1000.0


def _moved(pieces: Sequence[Piece]) -> Floats:
    """Where the vertices stand that targets move by more than a tenth of the most that any vertex moves."""
    found, most = [], 0.0
    for piece in pieces:
        for _, offsets in piece.targets.values():
            most = max(most, float(np.abs(offsets).max(initial=0.0)))
    for piece in pieces:
        chosen = np.zeros(len(piece.vertices), dtype=bool)
        for rows, offsets in piece.targets.values():
            chosen[rows[np.abs(offsets).max(axis=1) > 0.1 * most]] = True
        found.append(piece.vertices[chosen])
    points = np.concatenate(found) if found else np.zeros((0, 3))
    return points if len(points) > 2 else np.concatenate([piece.vertices for piece in pieces])


def _blinking(foreign: ForeignFace, pieces: Sequence[Piece]) -> Floats:
    """Where vertices stand that blinks move."""
    names = {
        f"{mesh.number}/{place}"
        for mesh in foreign.meshes
        for place, target in enumerate(mesh.targets)
        for drive in target.drives
        if drive.match.recipe.get("eyeBlinkLeft") or drive.match.recipe.get("eyeBlinkRight")
    }
    rows = [p.vertices[r] for p in pieces for name, (r, _) in p.targets.items() if name in names and len(r)]
    return np.concatenate(rows) if rows else np.zeros((0, 3))


def _part(piece: Piece, name: str, placed: _Placing, turns: bool) -> Part:
    vertices = placed.points(piece.vertices)
    if not np.abs(vertices).max(initial=0.0) < _FARTHEST:
        raise InputError(f"{piece.name!r} cannot be drawn: a vertex lies {np.abs(vertices).max():.3g} mm from the eyes")
    targets = {}
    for target, (rows, offsets) in piece.targets.items():
        moved = placed.offsets(offsets)
        chosen = np.abs(moved).max(axis=1, initial=0.0) > _LEAST
        if chosen.any():
            targets[target] = Target(rows[chosen].astype(np.int32), moved[chosen].astype(np.float32))
    weight = piece.head_weight if turns else np.clip((vertices[:, 1] - _CHIN) / _RAMP + 1.0, 0.0, 1.0)
    surface: Surface = piece.surface
    return Part(
        name=name,
        vertices=vertices.astype(np.float32),
        triangles=piece.triangles.astype(np.int32),
        uv=piece.uv.astype(np.float32),
        colours=piece.colours.astype(np.float32),
        material=replace(surface.material),
        # Rims of clothes do not fade out as the rim of a bust does.
        head_weight=np.maximum(weight, _TRUNK).astype(np.float32),
        targets=targets,
    )
