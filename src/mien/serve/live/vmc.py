"""Frames as packets of the VMC protocol (Virtual Motion Capture, protocol.vmc.info), for VRM avatars.

Each frame is one OSC bundle: ``/VMC/Ext/OK``, ``/VMC/Ext/T``, ``/VMC/Ext/Blend/Val`` for every shape,
``/VMC/Ext/Blend/Apply``, and the head as ``/VMC/Ext/Bone/Pos``. Space is Unity's: left-handed, x to the right of the
avatar, y up, z forward, metres; turns are quaternions x, y, z, w.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray

from mien.core.assets import asset_table
from mien.core.channels import ARKIT, HEAD
from mien.core.errors import InputError, unknown_name
from mien.face.posing import head_rotation
from mien.serve.live.frames import Frame
from mien.serve.live.osc import encode_bundle, encode_message

__all__ = ["SHAPES", "VmcEncoder"]

SHAPES = ("arkit", "vrm")
"""Names under which shapes are sent: all 52 of ARKit ("perfect sync"), or the presets that every VRM avatar has."""


class VmcEncoder:
    """Makes VMC packets of frames.

    Parameters
    ----------
    channels : sequence of str
        Of the frames.
    shapes : {"arkit", "vrm"}
        ``"arkit"``: names as in ``BrowInnerUp``; ``"vrm"``: A, I, U, E, O, Blink_L, Blink_R by a hand-made table.

    Raises
    ------
    InputError
        If the shapes are not known, or the channels lack one of ARKit's or of the head's.
    """

    def __init__(self, channels: Sequence[str], shapes: str = "arkit") -> None:
        if shapes not in SHAPES:
            raise unknown_name("set of VMC shapes", shapes, SHAPES)
        missing = [name for name in (*ARKIT, *HEAD) if name not in channels]
        if missing:
            raise InputError(f"VMC needs the channels of ARKit and of the head; {missing[0]} is missing")
        table = _shape_table()[shapes]
        self._names = tuple(table)
        self._mix = np.array([[table[name].get(channel, 0.0) for channel in channels] for name in table])
        self._head = [tuple(channels).index(name) for name in HEAD]

    def encode(self, frame: Frame) -> bytes:
        """The packet of one frame."""
        weights = np.clip(self._mix @ frame.values, 0.0, 1.0)
        turn = _unity_quaternion(*frame.values[self._head])
        return encode_bundle(
            encode_message("/VMC/Ext/OK", 1),
            encode_message("/VMC/Ext/T", float(frame.time)),
            *(encode_message("/VMC/Ext/Blend/Val", n, float(w)) for n, w in zip(self._names, weights, strict=True)),
            encode_message("/VMC/Ext/Blend/Apply"),
            encode_message("/VMC/Ext/Bone/Pos", "Head", 0.0, 0.0, 0.0, *(float(part) for part in turn)),
        )


@cache
def _shape_table() -> dict[str, dict[str, dict[str, float]]]:
    exact = {name[0].upper() + name[1:]: {name: 1.0} for name in ARKIT}
    return {"arkit": exact, **asset_table("live/vmc.toml")}


def _unity_quaternion(yaw: float, pitch: float, roll: float) -> NDArray[np.float64]:
    """A turn of the head as a quaternion in Unity's axes: x points the other way, so y and z change sign."""
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_matrix(head_rotation(float(yaw), float(pitch), float(roll))).as_quat(canonical=True)
    return np.asarray(turn * (1.0, -1.0, -1.0, 1.0))
