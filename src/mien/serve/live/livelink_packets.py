"""Frames as the UDP packets of Epic's Live Link Face app, which Unreal Engine listens to on port 11111.

A packet, big-endian: version (uint8, 6), device and subject as a length (int32) and that many bytes of UTF-8, frame
(int32) and part of a frame (float32), frames per second as numerator and denominator (int32 each), how many numbers
follow (uint8, 61), and the numbers (float32): the 52 ARKit weights, then yaw, pitch, roll of head, left and right eye
in radians, as in the app's CSV (`mien.formats.livelink`).
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.formats.livelink import MOTION_COLUMNS

__all__ = ["LiveLinkPacket", "decode_livelink", "encode_livelink"]

_VERSION = 6
_TIME = struct.Struct(">if2i")


@dataclass(frozen=True, eq=False)
class LiveLinkPacket:
    """What one packet holds.

    Attributes
    ----------
    device, subject : str
        The sender (a UUID in the app), and the name under which the engine shows it.
    frame : int
    rate : tuple of (int, int)
        Frames per second, numerator and denominator.
    numbers : ndarray, shape (61,)
        In the order of `mien.formats.livelink.MOTION_COLUMNS`.
    """

    device: str
    subject: str
    frame: int
    rate: tuple[int, int]
    numbers: NDArray[np.float64]


def encode_livelink(packet: LiveLinkPacket) -> bytes:
    """The bytes of a packet."""
    names = b"".join(struct.pack(">i", len(name)) + name for name in (packet.device.encode(), packet.subject.encode()))
    time = _TIME.pack(packet.frame, 0.0, *packet.rate)
    numbers = packet.numbers.astype(">f4").tobytes()
    return struct.pack("B", _VERSION) + names + time + struct.pack("B", len(packet.numbers)) + numbers


def decode_livelink(data: bytes) -> LiveLinkPacket:
    """Read a packet.

    Raises
    ------
    InputError
        If it is none, or cut short.
    """
    try:
        if data[0] != _VERSION:
            raise ValueError(f"version {data[0]}")
        device, place = _text(data, 1)
        subject, place = _text(data, place)
        frame, _, numerator, denominator = _TIME.unpack_from(data, place)
        place += _TIME.size
        count = data[place]
        if count != len(MOTION_COLUMNS) or len(data) != place + 1 + 4 * count:
            raise ValueError(f"{count} numbers in {len(data)} bytes")
        numbers = np.frombuffer(data, ">f4", count, place + 1).astype(np.float64)
        return LiveLinkPacket(device, subject, frame, (numerator, denominator), numbers)
    except (ValueError, IndexError, struct.error) as problem:
        raise InputError(f"expected a packet of Live Link Face, got {len(data)} bytes ({problem})") from problem


def _text(data: bytes, place: int) -> tuple[str, int]:
    (length,) = struct.unpack_from(">i", data, place)
    if not 0 <= length <= len(data) - place - 4:
        raise ValueError(f"a name of {length} bytes")
    return data[place + 4 : place + 4 + length].decode(), place + 4 + length
