"""As much of protocol buffers as writing a few fields of an ONNX file takes."""

from __future__ import annotations

from collections.abc import Iterator

__all__ = ["message_fields", "number", "read_varint", "text", "varint"]

_LENGTH_DELIMITED = 2
_FIXED = {1: 8, 5: 4}


def varint(value: int) -> bytes:
    r"""A number in steps of seven bits.

    Examples
    --------
    >>> varint(300)
    b'\xac\x02'
    """
    found = bytearray()
    while value > 0x7F:
        found.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes([*found, value])


def number(field: int, value: int) -> bytes:
    """A field that holds a number."""
    return varint(field << 3) + varint(value)


def text(field: int, content: bytes | str) -> bytes:
    r"""A field that holds a text, bytes or another message.

    Examples
    --------
    >>> text(1, "a")
    b'\n\x01a'
    """
    content = content.encode() if isinstance(content, str) else content
    return varint(field << 3 | _LENGTH_DELIMITED) + varint(len(content)) + content


def read_varint(message: bytes, place: int) -> tuple[int, int]:
    """A number and the place behind it.

    Raises
    ------
    ValueError
        If it has no end.
    """
    value = shift = 0
    for byte in message[place : place + 10]:
        place += 1
        value |= (byte & 0x7F) << shift
        shift += 7
        if byte < 0x80:
            return value, place
    raise ValueError("a number has no end")


def message_fields(message: bytes) -> Iterator[tuple[int, bytes, bytes]]:
    r"""Fields of a message: number, content (of a number: nothing), and the field as it stands.

    Raises
    ------
    ValueError
        If it is no message.

    Examples
    --------
    >>> list(message_fields(text(1, "a") + number(2, 5)))
    [(1, b'a', b'\n\x01a'), (2, b'', b'\x10\x05')]
    """
    place = 0
    while place < len(message):
        start = place
        key, place = read_varint(message, place)
        kind, content = key & 7, place
        if kind == 0:
            place = content = read_varint(message, place)[1]
        elif kind == _LENGTH_DELIMITED:
            length, content = read_varint(message, place)
            place = content + length
        elif kind in _FIXED:
            place = content + _FIXED[kind]
        else:
            raise ValueError(f"no kind of field: {kind}")
        if place > len(message):
            raise ValueError("a field is longer than the message that holds it")
        yield key >> 3, message[content:place], message[start:place]
