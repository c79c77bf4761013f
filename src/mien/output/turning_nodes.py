"""Head and eyes of a GLB of another maker: the nodes that turn, found by their names.

The turn is laid on top of the node's own rest, about the axes of the world (y up, z forward out of the face), whatever
axes the bone itself has: ``rest' = P^-1 T P rest`` with P the turn of the node's parents.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from importlib import resources
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.errors import Note
from mien.face.posing import head_rotation
from mien.tracks import ChannelTrack

__all__ = ["turning_nodes", "turns_of_nodes"]

Floats = NDArray[np.float64]
_EYE_DEGREES = {"Up": 18.0, "Down": 24.0, "In": 28.0, "Out": 30.0}
"""How far an eye turns at weight 1 of its eyeLook channels. Authored: the file does not tell."""


def turning_nodes(document: Mapping[str, Any]) -> dict[str, int]:
    """Numbers of the nodes named like the head, the left and the right eye (speaker's own), as far as there are any."""
    table = tomllib.loads((resources.files("mien") / "assets" / "rigs" / "names.toml").read_text("utf-8"))["nodes"]
    plain = [re.sub(r"[^a-z0-9]", "", str(node.get("name", "")).lower()) for node in document.get("nodes", [])]
    found = {}
    for part, names in table.items():
        places = [plain.index(name) for name in names if name in plain]
        if places and _turns_by_itself(document["nodes"][places[0]]):
            found[part] = places[0]
    return found


def _turns_by_itself(node: Mapping[str, Any]) -> bool:
    """Whether turning a node turns what it is named for about its own place: a bone, or a mesh that stands there."""
    return "skin" not in node and ("mesh" not in node or any(node.get("translation", ())))


def turns_of_nodes(track: ChannelTrack, document: Mapping[str, Any]) -> tuple[dict[int, Floats], tuple[Note, ...]]:
    """Rotations of the turning nodes over time (quaternions x, y, z, w; shape (frames, 4)) by node; what is missing."""
    from scipy.spatial.transform import Rotation

    nodes = turning_nodes(document)
    turns = {
        "head": np.array([head_rotation(*row) for row in track.select(("headYaw", "headPitch", "headRoll")).values])
    }
    for side, outward in (("Left", 1.0), ("Right", -1.0)):
        look = {way: track.select([f"eyeLook{way}{side}"]).values[:, 0] * _EYE_DEGREES[way] for way in _EYE_DEGREES}
        yaw, pitch = outward * (look["Out"] - look["In"]), look["Up"] - look["Down"]
        turns[f"eye{side}"] = np.array([head_rotation(y, p, 0.0) for y, p in zip(yaw, pitch, strict=True)])
    result = {}
    for part, number in nodes.items():
        if "matrix" in document["nodes"][number]:
            continue
        above = _turn_above(document, number)
        rest = Rotation.from_quat(document["nodes"][number].get("rotation", [0.0, 0.0, 0.0, 1.0]))
        quaternions = (above.inv() * Rotation.from_matrix(turns[part]) * above * rest).as_quat()
        flips = np.cumprod(np.where((quaternions[1:] * quaternions[:-1]).sum(axis=1) < 0, -1.0, 1.0))
        quaternions[1:] *= flips[:, None]
        result[number] = quaternions
    missing = [name for part, name in (("head", "head"), ("eyeLeft", "left eye"), ("eyeRight", "right eye"))
               if nodes.get(part) not in result]  # fmt: skip
    if not missing:
        return result, ()
    return result, (Note("note", f"no node that could turn is named like a {' or a '.join(missing)}: it stays still"),)


def _turn_above(document: Mapping[str, Any], number: int) -> Any:
    """The turn of all parents of a node, at rest."""
    from scipy.spatial.transform import Rotation

    parent = {child: place for place, node in enumerate(document["nodes"]) for child in node.get("children", [])}
    turn, seen = Rotation.identity(), {number}
    while number in parent and parent[number] not in seen:
        number = parent[number]
        seen.add(number)
        node = document["nodes"][number]
        if "matrix" in node:
            own = Rotation.from_matrix(_without_scale(np.reshape(node["matrix"], (4, 4)).T[:3, :3]))
        else:
            own = Rotation.from_quat(node.get("rotation", [0.0, 0.0, 0.0, 1.0]))
        turn = own * turn
    return turn


def _without_scale(matrix: Floats) -> Floats:
    return np.asarray(matrix / np.linalg.norm(matrix, axis=0))
