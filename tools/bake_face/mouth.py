"""Lips: sealed at rest, and kept sealed in the shapes that are made with a closed mouth."""

from __future__ import annotations

import numpy as np
from contact import Edges, edges_between, geodesic
from head import Head
from sculpt import smoothstep

_SEALED = 0.05  # mm of air between lips that touch
_ROLLED = -0.2  # the same of rolled lips, which overlap: two rolls add up
_CHEEK = 3.0  # mm from the middle of the row of teeth to the cheek's inside
_PALATE = -50.0  # y over which the lining is pressed down, mm
# Shapes of a closed mouth; the lips stay together in each of them.
CLOSED = (
    "jawForward", "jawLeft", "jawRight", "mouthPucker", "mouthLeft", "mouthRight", "mouthSmileLeft", "mouthSmileRight",
    "mouthFrownLeft", "mouthFrownRight", "mouthDimpleLeft", "mouthDimpleRight", "mouthStretchLeft",
    "mouthStretchRight", "mouthRollLower", "mouthRollUpper", "mouthShrugLower", "mouthPressLeft", "mouthPressRight",
    "mouthSharpPullLeft", "mouthSharpPullRight", "mouthTightenLeft", "mouthTightenRight", "nasolabialDeepenLeft",
    "nasolabialDeepenRight", "noseFlareLeft", "noseFlareRight", "noseCompressLeft", "noseCompressRight",
    "cheekPuff", "cheekSquintLeft", "cheekSquintRight", "noseSneerLeft", "noseSneerRight",
)  # fmt: skip


# Shapes that go farther than lips do on this face.
_TAMED = {"mouthRollUpper": 0.62, "jawForward": 0.6}


def lip_edges(head: Head) -> Edges:
    """The two lips as edges that meet."""
    skin = head.skin
    return edges_between(skin.vertices, skin.triangles, head.lip_loop, reach=9.0, pull=7.0, columns=True)


def seal_lips(head: Head) -> Edges:
    """Close the lips at rest and in the shapes of a closed mouth; ``mouthClose`` undoes ``jawOpen``."""
    skin = head.skin
    lips = lip_edges(head)
    skin.vertices = skin.vertices + lips.closing(skin.vertices, _SEALED)
    for name, share in _TAMED.items():
        skin.shapes[name] = skin.shapes[name] * share
    seal_shapes(head, lips)
    return lips


def seal_shapes(head: Head, lips: Edges) -> None:
    """The part of it that concerns shapes."""
    skin = head.skin
    for name in CLOSED:
        wanted = _ROLLED if "Roll" in name else _SEALED
        skin.shapes[name] = skin.shapes[name] + lips.closing(skin.posed(**{name: 1.0}), wanted, smooth=4.0)
    together = skin.posed(jawOpen=1.0, mouthClose=1.0)
    skin.shapes["mouthClose"] = skin.shapes["mouthClose"] + lips.closing(together, -_SEALED)


def line_mouth(head: Head, front: float) -> None:
    """Lay the mouth's lining to the teeth: cheeks beside them, the palate over them; MakeHuman's bag is far wider.

    ``front`` is z of the upper teeth's front.
    """
    skin = head.skin
    x, y, z = skin.vertices.T
    deep = geodesic(skin.vertices, skin.triangles, head.lip_loop)
    inside = smoothstep(0.5, 0.9, head.masks["inside-mouth"]) * smoothstep(5.0, 16.0, deep)
    angle = np.arccos(np.clip(1 - (front - z) / 46.0, 0.0, 1.0))
    wide = np.where(z > front - 46.0, 27.0 * np.sin(angle), 27.0) + _CHEEK
    beyond = np.maximum(np.abs(x) - wide, 0.0)
    skin.vertices[:, 0] -= np.sign(x) * 0.85 * beyond * inside
    skin.vertices[:, 1] -= 0.72 * np.maximum(y - _PALATE, 0.0) * inside


def widest_gap(lips: Edges, shape: np.ndarray) -> float:
    """The widest opening between the lips, millimetres."""
    return float(lips.gap(shape)[1].max(initial=0.0))
