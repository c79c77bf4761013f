"""The messages of a mien stream (``docs/live.md``): one greeting in text, then frames in binary.

A client first gets the greeting, JSON in text::

    {"format": "mien-live", "version": 1, "channels": ["eyeBlinkLeft", ...], "fps": 30.0, "facts": {...}}

Every frame is one binary message, little-endian::

    offset  type              what
    0       uint8             1: a frame
    1       uint8             version, 1
    2       uint16            n, how many numbers follow
    4       uint32            number of the frame, counted from 0; a gap means that frames were skipped for this client
    8       float64           seconds of the stream at which the frame stands
    16      float32 * n       the channels, in the order of the greeting

A message in text after the greeting is an event: ``{"event": "began", "at": ...}`` tells the moment of frame 0 (seconds
since 1970) to whom the greeting could not, ``{"event": "end"}`` is the last.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.core.plain_text import parsed_json

__all__ = ["END", "FORMAT", "VERSION", "Frame", "Greeting", "decode_frame", "encode_frame"]

FORMAT, VERSION = "mien-live", 1
END = json.dumps({"event": "end"})
"""The last message of a stream that ends."""
_HEAD = struct.Struct("<BBHId")
_FRAME = 1


@dataclass(frozen=True, eq=False)
class Frame:
    """One instant of a stream.

    Attributes
    ----------
    number : int
        Counted from 0.
    time : float
        Seconds of the stream.
    values : ndarray, shape (channels,)
        In the order of the greeting's channels; units as in `mien.core.channels`.
    clock : float or None
        Seconds of this machine's day at which it stands: for the timecode of engines.
    """

    number: int
    time: float
    values: NDArray[np.float64]
    clock: float | None = None


@dataclass(frozen=True)
class Greeting:
    """What a client must know before the first frame.

    Attributes
    ----------
    channels : tuple of str
    fps : float
    facts : mapping of str to any
        What the sender wants to tell: text, words, phones, performer. JSON.
    """

    channels: tuple[str, ...]
    fps: float
    facts: Mapping[str, Any] = field(default_factory=dict)

    def encode(self, began: float | None = None) -> str:
        """The message, in text; ``began`` is the moment of frame 0, seconds since 1970, if it is known."""
        content = {"format": FORMAT, "version": VERSION, "channels": self.channels, "fps": self.fps}
        return json.dumps({**content, "facts": {**self.facts, "began": began}}, ensure_ascii=False)

    @classmethod
    def decode(cls, message: str) -> Greeting:
        """Read a greeting.

        Raises
        ------
        InputError
            If it is none, or of another version.

        Examples
        --------
        >>> Greeting.decode(Greeting(("jawOpen",), 30.0).encode()).channels
        ('jawOpen',)
        """
        try:
            content = parsed_json(message)
            if (content["format"], content["version"]) != (FORMAT, VERSION):
                raise InputError(f"expected {FORMAT} {VERSION}, got {content['format']} {content['version']}")
            return cls(_names(content["channels"]), float(content["fps"]), content.get("facts", {}))
        except (ValueError, KeyError, TypeError, OverflowError) as problem:
            raise InputError(f"expected the greeting of a mien stream, got {message[:40]!r} ({problem})") from problem


def _names(channels: Sequence[Any]) -> tuple[str, ...]:
    if not all(isinstance(name, str) for name in channels):
        raise ValueError("channels are names")
    return tuple(channels)


def encode_frame(frame: Frame) -> bytes:
    """The binary message of a frame; numbers are rounded to 32 bits.

    Examples
    --------
    >>> len(encode_frame(Frame(0, 0.0, np.zeros(57))))
    244
    """
    return (
        _HEAD.pack(_FRAME, VERSION, len(frame.values), frame.number, frame.time) + frame.values.astype("<f4").tobytes()
    )


def decode_frame(message: bytes) -> Frame:
    """Read the binary message of a frame.

    Raises
    ------
    InputError
        If it is none, of another version, or cut short.
    """
    if len(message) < _HEAD.size:
        raise InputError(f"expected a frame of at least {_HEAD.size} bytes, got {len(message)}")
    kind, version, count, number, time = _HEAD.unpack_from(message)
    if (kind, version) != (_FRAME, VERSION):
        raise InputError(f"expected message {_FRAME} of version {VERSION}, got message {kind} of version {version}")
    if len(message) != _HEAD.size + 4 * count:
        raise InputError(
            f"frame {number}: expected {_HEAD.size + 4 * count} bytes for {count} channels, got {len(message)}"
        )
    return Frame(number, time, np.frombuffer(message, "<f4", count, _HEAD.size).astype(np.float64))
