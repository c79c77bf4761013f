"""How far the shapes of expression go, and which way: MakeHuman's units are milder than faces that feel.

All hand-made. The greatest movements at full are held against shapes that artists made from scans (ICT-FaceKit, Li et
al. 2020: browInnerUp 6.1 mm, browOuterUp 8.6, noseSneer 10.3, mouthUpperUp 8.8, mouthStretch 10.3, mouthPucker 12.4,
mouthPress 4.3) and against what actors need (an angry inner brow 5.4 mm below rest: a shape that ends at 4.3 stands at
its ceiling all the time). AU4 in FACS lowers the *inner* end of the brow most and draws the brows together.
"""

from __future__ import annotations

import numpy as np
from head import Head
from makehuman import Floats
from sculpt import Sculpt, smoothstep, vertex_normals

_SIDES = (("Left", 1.0), ("Right", -1.0))
# How much farther a shape goes than MakeHuman's unit.
_FARTHER = {
    "browInnerUp": 1.30,
    "browOuterUpLeft": 1.30,
    "browOuterUpRight": 1.30,
    "mouthStretchLeft": 1.20,
    "mouthStretchRight": 1.20,
    "mouthPucker": 1.35,
}
_HEAD = (12.0, 15.0, 8.0)  # x, y of a brow's inner end and how far about it, mm
_CORNER = (28.0, -62.0, 15.0)  # the same of a mouth's corner
_SMILE = (1.10, 0.85, 1.30)  # a corner goes back round the teeth as much as up
_SMILING_LIPS = 0.35  # of the way up of the lips' middle remains in a smile: the corners rise from it, it does not rise
_PRESS = 0.35  # of the way aside and up that MakeHuman's pressed lips take their corners: pressing is no smile


def strengthen(head: Head) -> None:
    """Make the shapes of expression as strong as faces are; before `muscles.add_muscles` builds on them."""
    skin = head.skin
    for name, share in _FARTHER.items():
        skin.shapes[name] = skin.shapes[name] * share
    for sign in (1.0, -1.0):
        skin.shapes["browInnerUp"] = skin.shapes["browInnerUp"] + np.outer(_about(skin, sign, _HEAD), [0.0, 1.8, 0.0])
    for side, sign in _SIDES:
        x, y, z = (skin.vertices * np.array([sign, 1.0, 1.0])).T
        corner = _about(skin, sign, _CORNER)[:, None]
        middle = np.exp(-((x / 15.0) ** 2) - (((y + 68.0) / 16.0) ** 2)) * smoothstep(-20.0, 0.0, z)
        smile, press, sneer, raised = (
            name + side for name in ("mouthSmile", "mouthPress", "noseSneer", "mouthUpperUp")
        )
        skin.shapes[smile] = skin.shapes[smile] * (1 + corner * (np.array(_SMILE) - 1))
        skin.shapes[smile] = skin.shapes[smile] * (1 - (1 - _SMILING_LIPS) * middle[:, None] * [0.0, 1.0, 0.0])
        skin.shapes[press] = skin.shapes[press] * (1 + corner * (_PRESS - 1))
        # A sneer and a raised lip are strongest under the wing of the nose, not in the middle.
        levator = np.exp(-(((x - 21.0) / 9.0) ** 2) - (((y + 48.0) / 10.0) ** 2)) * smoothstep(-10.0, 8.0, z)
        skin.shapes[sneer] = skin.shapes[sneer] + np.outer(levator, [-0.8 * sign, 5.6, 1.0])
        lateral = smoothstep(2.0, 13.0, x)[:, None]
        skin.shapes[raised] = skin.shapes[raised] * (1.05 + 0.5 * lateral) + np.outer(levator, [0.6 * sign, 3.4, 0.6])
        skin.shapes["browDown" + side] = skin.shapes["browDown" + side] + _frown(skin, sign)


def _about(skin: Sculpt, sign: float, place: tuple[float, float, float]) -> Floats:
    """1 at a place of one side, falling off around it; from the front of the face only."""
    x, y, width = place
    away = ((sign * skin.vertices[:, 0] - x) ** 2 + (skin.vertices[:, 1] - y) ** 2) / width**2
    return np.asarray(np.exp(-away) * smoothstep(-20.0, 0.0, skin.vertices[:, 2]))


def _frown(skin: Sculpt, sign: float) -> Floats:
    """AU4 beyond MakeHuman's unit: the inner end lower and nearer, the outer held; furrows between the brows."""
    x, y, z = (skin.vertices * np.array([sign, 1.0, 1.0])).T
    front = smoothstep(-5.0, 8.0, z) * smoothstep(5.0, 11.0, y)
    inner = np.exp(-(((x - 13.0) / 12.0) ** 2) - (((y - 15.0) / 13.0) ** 2)) * front
    outer = np.exp(-(((x - 46.0) / 12.0) ** 2) - (((y - 20.0) / 14.0) ** 2)) * front
    moved = np.outer(inner, [-1.6 * sign, -4.0, 1.0]) + np.outer(outer, [0.0, 1.2, 0.0])
    between = smoothstep(3.0, 9.0, y) * smoothstep(30.0, 21.0, y) * smoothstep(5.0, 12.0, z)
    groove = -1.3 * np.exp(-(((x - 6.5) / 2.0) ** 2)) * between
    bank = 0.9 * np.exp(-(((x - 11.5) / 3.0) ** 2)) * between
    return np.asarray(moved + vertex_normals(skin.vertices, skin.triangles) * (groove + bank)[:, None])
