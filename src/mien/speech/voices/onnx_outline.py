"""An ONNX file without its weights: they stay on the disk, and the runtime maps them from there.

An ONNX file is a protocol buffer: ``ModelProto.graph`` (field 7) holds the nodes and, as ``GraphProto.initializer``
(field 5), the weights. Here the file is walked field by field; weights are passed over, and in the outline each is
named by file, place and length (``TensorProto.external_data``, field 13, with ``data_location``, field 14;
https://onnx.ai/onnx/repo-docs/ExternalData.html). Of a network of 90 MB nine tenths are then never copied. On the way
convolutions are given signed sound (`mien.speech.voices.signed_convolutions`).
"""

from __future__ import annotations

import os
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from itertools import accumulate
from mmap import ACCESS_READ, mmap
from pathlib import Path

from mien.speech.voices.protocol_buffer import number as number_field
from mien.speech.voices.protocol_buffer import read_varint, text
from mien.speech.voices.signed_convolutions import SIGN_BIT, signed_convolution

__all__ = ["outline"]

_GRAPH, _NODE, _INITIALIZER = 7, 1, 5
_RAW_DATA, _EXTERNAL_DATA, _DATA_LOCATION = 9, 13, 14
_KEY, _VALUE = 1, 2
_EXTERNAL = 1
_LENGTH_DELIMITED = 2
_LONGEST = 10  # bytes of a number
_SMALLEST = 4096
"""Bytes from which a weight is left where it is."""


class _Parts:
    """The bytes of a file that is cut into several, read where they are asked for."""

    def __init__(self, paths: Sequence[Path]) -> None:
        self.paths = paths
        self.maps = [_mapped(path) for path in paths]
        self.starts = [0, *accumulate(len(part) for part in self.maps)]
        self._here = 0, self.starts[1], self.maps[0]

    def bytes(self, start: int, stop: int) -> bytes:
        number = bisect_right(self.starts, start) - 1
        found = b""
        while start < stop and number < len(self.maps):
            first, last = self.starts[number], min(stop, self.starts[number + 1])
            found += self.maps[number][start - first : last - first]
            start, number = last, number + 1
        return found

    def within_one(self, start: int, stop: int) -> tuple[Path, int] | None:
        """The file in which a whole stretch lies, and its place there; None if it is cut."""
        number = bisect_right(self.starts, start) - 1
        if stop > self.starts[number + 1]:
            return None
        return self.paths[number], start - self.starts[number]

    def varint(self, place: int) -> tuple[int, int]:
        """A number and the place behind it."""
        first, last, part = self._here
        if not first <= place < last:
            number = min(bisect_right(self.starts, place), len(self.maps)) - 1
            first, last, part = self._here = self.starts[number], self.starts[number + 1], self.maps[number]
        if place + _LONGEST <= last:
            value, end = read_varint(part[place - first : place - first + _LONGEST], 0)
        else:
            value, end = read_varint(self.bytes(place, place + _LONGEST), 0)
        return value, place + end

    def fields(self, start: int, stop: int) -> Iterator[tuple[int, int, int, int]]:
        """Fields of a message: number, where it starts, where its content starts, where it ends."""
        while start < stop:
            key, content = self.varint(start)
            kind = key & 7
            if kind == 0:
                end = self.varint(content)[1]
            elif kind == _LENGTH_DELIMITED:
                length, content = self.varint(content)
                end = content + length
            elif kind in (1, 5):
                end = content + (8 if kind == 1 else 4)
            else:
                raise ValueError(f"no kind of field: {kind}")
            if end > stop:
                raise ValueError("a field is longer than the message that holds it")
            yield key >> 3, start, content, end
            start = end


def _mapped(path: Path) -> mmap:
    with path.open("rb") as file:
        return mmap(file.fileno(), 0, access=ACCESS_READ)


def outline(paths: Sequence[Path]) -> tuple[bytes, Path]:
    """An ONNX model whose large weights are named by their place, and the folder from which they are named.

    Parameters
    ----------
    paths : sequence of Path
        The file, or the files into which it is cut, in order.

    Raises
    ------
    OSError
        If a file cannot be read.
    ValueError
        If it is no protocol buffer, or the files share no folder.
    """
    parts = _Parts(paths)
    folder = Path(os.path.commonpath([path.parent for path in paths]))
    model = []
    for number, start, content, end in parts.fields(0, parts.starts[-1]):
        if number == _GRAPH:
            model.append(text(_GRAPH, b"".join(_graph(parts, content, end, folder))))
        else:
            model.append(parts.bytes(start, end))
    return b"".join(model), folder


def _graph(parts: _Parts, start: int, end: int, folder: Path) -> Iterator[bytes]:
    """What lies between large weights and convolutions is copied as it stands."""
    copied, signed = start, set[str]()
    for field, whole, content, stop in parts.fields(start, end):
        if field == _INITIALIZER and stop - content >= _SMALLEST:
            changed = [_outlined(parts, content, stop, folder)]
        elif field == _NODE and (nodes := signed_convolution(parts.bytes(content, stop), signed)):
            changed = [text(_NODE, node) for node in nodes]
        else:
            continue
        yield from (parts.bytes(copied, whole), *changed)
        copied = stop
    yield parts.bytes(copied, end)
    if signed:
        yield text(_INITIALIZER, SIGN_BIT)


def _outlined(parts: _Parts, start: int, end: int, folder: Path) -> bytes:
    """The field of one weight, without its numbers if they lie in one file."""
    kept = []
    for number, field, content, stop in parts.fields(start, end):
        found = parts.within_one(content, stop) if number == _RAW_DATA else None
        if found is None:
            kept.append(parts.bytes(field, stop))
            continue
        path, place = found
        facts = {"location": path.relative_to(folder).as_posix(), "offset": str(place), "length": str(stop - content)}
        for key, value in facts.items():
            kept.append(text(_EXTERNAL_DATA, text(_KEY, key) + text(_VALUE, value)))
        kept.append(number_field(_DATA_LOCATION, _EXTERNAL))
    return text(_INITIALIZER, b"".join(kept))
