"""Frames as packets of the VMC protocol (Virtual Motion Capture, protocol.vmc.info), for VRM avatars.

Each frame is one OSC bundle: ``/VMC/Ext/OK``, ``/VMC/Ext/T``, ``/VMC/Ext/Blend/Val`` for every shape,
``/VMC/Ext/Blend/Apply``, and the head as ``/VMC/Ext/Bone/Pos``. Space is Unity's: left-handed, x to the right of the
avatar, y up, z forward, metres; turns are quaternions x, y, z, w.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache

import numpy as np

from mien.core.assets import asset_table
from mien.core.channels import ARKIT, HEAD
from mien.core.errors import InputError, unknown_name
from mien.face.posing import head_rotation
from mien.serve.live.frames import Frame
from mien.serve.live.osc import encode_bundle, encode_message

__all__ = ["SHAPES", "VmcEncoder"]

SHAPES = ("arkit", "vrm", "vrm1")
"""Names under which shapes are sent: all 52 of ARKit ("perfect sync"), or the presets that every VRM avatar has, as VRM
0 or VRM 1.0 names them."""
HEAD_REST = (0.0, 0.09, 0.01)
"""Metres from the neck bone to the head bone of a usual avatar, hand-made: a receiver that takes positions as they come
would else put the head into the neck."""


class VmcEncoder:
    """Makes VMC packets of frames.

    Parameters
    ----------
    channels : sequence of str
        Of the frames.
    shapes : {"arkit", "vrm", "vrm1"}
        ``"arkit"``: names as in ``BrowInnerUp``; ``"vrm"``: A, I, U, E, O, Blink_L, Blink_R, Joy, Angry, Sorrow, Fun,
        ``"vrm1"``: the same and Surprised as VRM 1.0 names them, by a hand-made table.
    head : tuple of float, or None
        Where the head bone rests, metres in its parent's space; None: the head is not sent.

    Raises
    ------
    InputError
        If the shapes are not known, or the channels lack one of ARKit's or of the head's.
    """

    def __init__(
        self, channels: Sequence[str], shapes: str = "arkit", head: tuple[float, float, float] | None = HEAD_REST
    ) -> None:
        if shapes not in SHAPES:
            raise unknown_name("set of VMC shapes", shapes, SHAPES)
        missing = [name for name in (*ARKIT, *HEAD) if name not in channels]
        if missing:
            raise InputError(f"VMC needs the channels of ARKit and of the head; {missing[0]} is missing")
        table = _shape_table()[shapes]
        self._names = tuple(table)
        self._mix = np.array([[table[name].get(channel, 0.0) for channel in channels] for name in table])
        self._rest = head
        self._head = [tuple(channels).index(name) for name in HEAD]

    def encode(self, frame: Frame) -> bytes:
        """The packet of one frame."""
        weights = np.clip(self._mix @ frame.values, 0.0, 1.0)
        turn = _unity_quaternion(*frame.values[self._head])
        bones = [] if self._rest is None else [encode_message("/VMC/Ext/Bone/Pos", "Head", *self._rest, *turn)]
        return encode_bundle(
            encode_message("/VMC/Ext/OK", 1),
            encode_message("/VMC/Ext/T", float(frame.time)),
            *(encode_message("/VMC/Ext/Blend/Val", n, float(w)) for n, w in zip(self._names, weights, strict=True)),
            encode_message("/VMC/Ext/Blend/Apply"),
            *bones,
        )


@cache
def _shape_table() -> dict[str, dict[str, dict[str, float]]]:
    exact = {name[0].upper() + name[1:]: {name: 1.0} for name in ARKIT}
    table = asset_table("live/vmc.toml")
    return {"arkit": exact, "vrm": table["vrm"], "vrm1": {new: table["vrm"][old] for new, old in table["vrm1"].items()}}


def _unity_quaternion(yaw: float, pitch: float, roll: float) -> tuple[float, float, float, float]:
    """A turn of the head as a quaternion in Unity's axes: x points the other way, so y and z change sign."""
    m = head_rotation(float(yaw), float(pitch), float(roll))
    w = 0.5 * math.sqrt(max(0.0, 1.0 + m[0, 0] + m[1, 1] + m[2, 2]))  # heads turn by less than 180 degrees: w > 0
    x, y, z = ((m[i, j] - m[j, i]) / (4.0 * w) for i, j in ((2, 1), (0, 2), (1, 0)))
    return float(x), float(-y), float(-z), float(w)
