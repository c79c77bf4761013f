"""Open Sound Control 1.0: messages and bundles as bytes, as far as the VMC protocol needs them.

Source: the OSC 1.0 specification (2002): strings end in a zero and are padded to four bytes, numbers are big-endian.
"""

from __future__ import annotations

import struct

from mien.core.errors import InputError

__all__ = ["decode_packet", "encode_bundle", "encode_message"]

Argument = int | float | str
Message = tuple[str, tuple[Argument, ...]]
_IMMEDIATELY = struct.pack(">Q", 1)


def encode_message(address: str, *arguments: Argument) -> bytes:
    r"""One message: int as ``i``, float as ``f``, str as ``s`` (UTF-8).

    Examples
    --------
    >>> encode_message("/a", 1)
    b'/a\x00\x00,i\x00\x00\x00\x00\x00\x01'
    """
    tags, body = ",", b""
    for argument in arguments:
        if isinstance(argument, str):
            tags, body = tags + "s", body + _padded(argument)
        elif isinstance(argument, int):
            tags, body = tags + "i", body + struct.pack(">i", argument)
        else:
            tags, body = tags + "f", body + struct.pack(">f", argument)
    return _padded(address) + _padded(tags) + body


def encode_bundle(*messages: bytes) -> bytes:
    """Messages to be acted on together, at once."""
    return _padded("#bundle") + _IMMEDIATELY + b"".join(struct.pack(">i", len(m)) + m for m in messages)


def decode_packet(packet: bytes) -> tuple[Message, ...]:
    """All messages of a packet, bundles unpacked.

    Raises
    ------
    InputError
        If it is no OSC packet.
    """
    try:
        if not packet.startswith(b"#bundle\0"):
            return (_decode_message(packet),)
        found: list[Message] = []
        place = 16
        while place < len(packet):
            (size,) = struct.unpack_from(">i", packet, place)
            if size <= 0 or place + 4 + size > len(packet):
                raise ValueError(f"an element of {size} bytes at byte {place}")
            found += decode_packet(packet[place + 4 : place + 4 + size])
            place += 4 + size
        return tuple(found)
    except (ValueError, struct.error) as problem:
        raise InputError(f"expected an OSC packet, got {packet[:16]!r} ({problem})") from problem


def _padded(text: str) -> bytes:
    content = text.encode() + b"\0"
    return content + b"\0" * (-len(content) % 4)


def _text(packet: bytes, place: int) -> tuple[str, int]:
    end = packet.index(b"\0", place)
    return packet[place:end].decode(), end + 4 - end % 4


def _decode_message(packet: bytes) -> Message:
    address, place = _text(packet, 0)
    tags, place = _text(packet, place)
    if not address.startswith("/") or not tags.startswith(","):
        raise ValueError("no address")
    arguments: list[Argument] = []
    for tag in tags[1:]:
        if tag == "s":
            value, place = _text(packet, place)
            arguments.append(value)
        elif tag in "if":
            arguments.append(struct.unpack_from(">" + tag, packet, place)[0])
            place += 4
        else:
            raise ValueError(f"arguments of type {tag!r} are not read here")
    return address, tuple(arguments)
