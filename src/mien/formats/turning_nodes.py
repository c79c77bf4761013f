"""Head and eyes of a face of another maker, over time.

The turn is laid on top of the node's own rest, about the axes of the world (y up, z forward out of the face), whatever
axes the bone itself has: ``rest' = P^-1 T P rest`` with P the turn of the node's parents. Where the face looks along
-z, T is turned with it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import Note
from mien.core.tracks import ChannelTrack
from mien.face.foreign.gltf_document import GltfDocument
from mien.face.foreign.recognition import ForeignFace
from mien.face.foreign.rig_names import name_tables
from mien.face.foreign.rig_nodes import PARTS, local_matrix, lowered_arms, parts_of
from mien.face.posing import head_rotation

__all__ = ["turns_of_nodes"]

Floats = NDArray[np.float64]
_NECK = 0.35  # of the head's turn, where there is a neck to take it; hand-made


def turns_of_nodes(track: ChannelTrack, face: ForeignFace) -> tuple[dict[int, Floats], tuple[Note, ...]]:
    """Rotations of the turning nodes over time (quaternions x, y, z, w; shape (frames, 4)) by node; what is missing."""
    from scipy.spatial.transform import Rotation

    document, nodes = face.document, face.turning.nodes
    turns, result = turns_of_parts(track, face), {}
    flipped = np.diag([-1.0, 1.0, -1.0]) if face.turning.facing < 0 else np.eye(3)
    for part, number in nodes.items():
        if part not in turns or (part == "jaw" and not face.jaw_turns):
            continue
        parts = parts_of(local_matrix(document.list_of("nodes")[number]))
        if parts is None:
            continue
        above, rest = _turn_above(document, number), Rotation.from_quat(parts[1])
        turned = Rotation.from_matrix(flipped @ turns[part] @ flipped)
        quaternions = np.asarray((above.inv() * turned * above * rest).as_quat())
        flips = np.cumprod(np.where((quaternions[1:] * quaternions[:-1]).sum(axis=1) < 0, -1.0, 1.0))
        quaternions[1:] *= flips[:, None]
        result[number] = quaternions
    for number, matrix in lowered_arms(document, nodes).items() if face.arms else ():
        posed = parts_of(matrix)
        if posed is not None:
            result[number] = np.tile(posed[1], (len(track), 1))
    missing = [
        told for part, told in PARTS.items() if nodes.get(part) not in result and part not in face.turning.by_shapes
    ]
    if not missing:
        return result, ()
    return result, (Note("note", f"no node that could turn is named like a {' or a '.join(missing)}: it stays still"),)


def turns_of_parts(track: ChannelTrack, face: ForeignFace) -> dict[str, Floats]:
    """Matrices of head, neck, eyes and jaw in every frame, shape (frames, 3, 3), in a face's own axes (z forward)."""
    angles = track.select(("headYaw", "headPitch", "headRoll")).values
    turns = {"head": np.array([head_rotation(*row) for row in angles]).reshape(-1, 3, 3)}
    if "neck" in face.turning.nodes:  # the head's turn in the world stays what it is
        turns["neck"] = np.array([head_rotation(*(_NECK * row)) for row in angles]).reshape(-1, 3, 3)
        turns["head"] = turns["neck"].transpose(0, 2, 1) @ turns["head"]
    degrees, jaw = face.turning.degrees, name_tables()["jaw"]
    across, down = (track.select(names).values for names in (("jawLeft", "jawRight"), ("jawOpen",)))
    swing, drop = jaw["Side"] * (across[:, 0] - across[:, 1]), -jaw["Open"] * down[:, 0]
    turns["jaw"] = np.array([head_rotation(y, p, 0.0) for y, p in zip(swing, drop, strict=True)]).reshape(-1, 3, 3)
    for side, outward in (("Left", 1.0), ("Right", -1.0)):
        look = {way: track.select([f"eyeLook{way}{side}"]).values[:, 0] * degrees[way] for way in degrees}
        yaw, pitch = outward * (look["Out"] - look["In"]), look["Up"] - look["Down"]
        pairs = zip(yaw, pitch, strict=True)
        turns[f"eye{side}"] = np.array([head_rotation(y, p, 0.0) for y, p in pairs]).reshape(-1, 3, 3)
    return turns


def _turn_above(document: GltfDocument, number: int) -> Any:
    """The turn of all parents of a node, at rest."""
    from scipy.spatial.transform import Rotation

    parents, turn = document.parents(), Rotation.identity()
    while number in parents:
        number = parents[number]
        matrix = local_matrix(document.list_of("nodes")[number])[:3, :3]
        length = np.linalg.norm(matrix, axis=0)
        if length.all() and np.linalg.det(matrix) > 0:
            turn = Rotation.from_matrix(matrix / length) * turn
    return turn
