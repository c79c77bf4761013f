"""EXT_meshopt_compression decoded: attributes, triangles and indices, and the exponential filter.

Source: EXT_meshopt_compression, appendices A (bitstreams) and B (filters), Khronos glTF extension registry. Of the
attributes' codec version 0 is known; the filters for normals and rotations are not needed to draw and are refused.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mien.core.compiled import njit

__all__ = ["decoded"]

_MOST = 512_000_000


def decoded(data: bytes, mode: str, count: int, stride: int, kind: str = "NONE") -> bytes:
    """The bytes of a compressed buffer view.

    Parameters
    ----------
    data : bytes
    mode : {"ATTRIBUTES", "TRIANGLES", "INDICES"}
    count, stride : int
        Elements, and bytes of each.
    kind : str
        Filter: ``NONE`` or ``EXPONENTIAL``.

    Raises
    ------
    ValueError
        If they are damaged, or of a kind that is not known here.
    """
    if not isinstance(count, int) or not isinstance(stride, int) or count < 0 or not 0 < stride <= 256:
        raise ValueError(f"count {count} and stride {stride} are out of range")
    if count * stride > _MOST:
        raise ValueError(f"{count} elements are more than mien takes")
    source = np.frombuffer(data, dtype=np.uint8)
    if mode == "ATTRIBUTES":
        if stride % 4:
            raise ValueError(f"a stride of {stride} is not a multiple of four")
        return _filtered(_attributes(source, count, stride), count, stride, kind)
    if mode not in ("TRIANGLES", "INDICES") or kind != "NONE" or stride not in (2, 4):
        raise ValueError(f"mode {mode!r} with stride {stride} and filter {kind!r} is not known")
    result = np.zeros(count, dtype=np.uint32)
    if mode == "TRIANGLES":
        if len(source) < 17 + count // 3 or source[0] != 0xE1 or count % 3:
            raise ValueError("triangles begin with 0xe1, and have a byte each and 17 besides")
        ended = _triangles(source, count, result)
    else:
        if len(source) < 5 or source[0] != 0xD1:
            raise ValueError("indices begin with 0xd1")
        ended = _sequence(source, result)
    if not ended:
        raise ValueError("the stream ends too early")
    return result.astype("<u2" if stride == 2 else "<u4").tobytes()


def _attributes(source: NDArray[np.uint8], count: int, stride: int) -> NDArray[np.uint8]:
    if len(source) < 1 + max(stride, 32) or source[0] != 0xA0:
        raise ValueError("attributes begin with 0xa0 (codec version 0) and end with 32 bytes or an element")
    result = np.zeros((count, stride), dtype=np.uint8)
    if not _attribute_blocks(source, count, stride, result):
        raise ValueError("the stream ends too early")
    return result


@njit(cache=True)
def _attribute_blocks(source, count, stride, result):  # type: ignore[no-untyped-def]
    at, end = 1, len(source) - max(stride, 32)
    last = source[len(source) - stride :].copy()
    most = min((8192 // stride) & ~15, 256)
    first = 0
    while first < count:
        block = min(most, count - first)
        groups = (block + 15) // 16
        for k in range(stride):
            header = at
            at += (groups + 3) // 4
            if at > end:
                return False
            value = last[k]
            for group in range(groups):
                mode = (source[header + group // 4] >> ((group % 4) * 2)) & 3
                bits = 0 if mode == 0 else 1 << mode  # 0, 2, 4, 8
                size = 2 * bits
                extra = at + size
                if extra > end:
                    return False
                for i in range(16):
                    if bits == 0:
                        delta = 0
                    elif bits == 8:
                        delta = int(source[at + i])
                    else:
                        per = 8 // bits
                        shift = 8 - bits * (i % per + 1)
                        delta = (int(source[at + i // per]) >> shift) & ((1 << bits) - 1)
                        if delta == (1 << bits) - 1:
                            if extra >= end:
                                return False
                            delta = int(source[extra])
                            extra += 1
                    place = group * 16 + i
                    if place < block:
                        value = np.uint8((int(value) + ((delta >> 1) ^ -(delta & 1))) & 255)
                        result[first + place, k] = value
                at = extra
            last[k] = result[first + block - 1, k]
        first += block
    return True


def _filtered(values: NDArray[np.uint8], count: int, stride: int, kind: str) -> bytes:
    if kind == "NONE":
        return values.tobytes()
    if kind != "EXPONENTIAL":
        raise ValueError(f"filter {kind!r} is not decoded here")
    words = values.view("<i4").reshape(count, stride // 4)
    exponent, mantissa = words >> 24, (words << 8) >> 8
    plain: bytes = np.ldexp(mantissa.astype(np.float64), exponent).astype("<f4").tobytes()
    return plain


@njit(cache=True)
def _varint(source, at, end):  # type: ignore[no-untyped-def]
    """A number of up to five bytes, and the place after it (-1 at the end)."""
    value = np.uint32(0)
    for i in range(5):
        if at >= end:
            return value, -1
        byte = source[at]
        at += 1
        value |= np.uint32(byte & 127) << np.uint32(7 * i)
        if byte < 128:
            break
    return value, at


@njit(cache=True)
def _step(value, last):  # type: ignore[no-untyped-def]
    """Zigzag difference onto the last index, modulo 2^32."""
    delta = (int(value) >> 1) ^ -(int(value) & 1)
    return (last + delta) & 0xFFFFFFFF


@njit(cache=True)
def _sequence(source, result):  # type: ignore[no-untyped-def]
    at, end = 1, len(source) - 4
    last = np.zeros(2, dtype=np.int64)
    for i in range(len(result)):
        value, at = _varint(source, at, end)
        if at < 0:
            return False
        which = int(value) & 1
        last[which] = _step(value >> np.uint32(1), last[which])
        result[i] = last[which]
    return True


@njit(cache=True)
def _triangles(source, count, result):  # type: ignore[no-untyped-def]
    """Fill ``result`` with the corners of the triangles; False if the stream ends early."""
    # Where the next code and the next loose byte lie; how many edges and vertices were remembered; the next vertex that
    # nothing named before, and the last one that was written out. A ring of 16 holds the remembered ones.
    at = np.array([1, 1 + count // 3])
    seen = np.zeros(2, dtype=np.int64)
    known = np.zeros(2, dtype=np.int64)
    edges = np.zeros((16, 2), dtype=np.int64)
    vertices = np.zeros(16, dtype=np.int64)
    for t in range(0, count, 3):
        token = int(source[at[0]])
        at[0] += 1
        if token < 0xF0:
            whole = _beside_an_edge(source, token, at, seen, known, edges, vertices, result, t)
        else:
            whole = _apart(source, token, at, seen, known, edges, vertices, result, t)
        if not whole:
            return False
    return True


@njit(cache=True)
def _beside_an_edge(source, token, at, seen, known, edges, vertices, result, t):  # type: ignore[no-untyped-def]
    """A triangle on a remembered edge: its third corner is new, remembered, or written out."""
    a, b = edges[(seen[0] - 1 - (token >> 4)) & 15]
    low = token & 15
    if low == 0:
        c = _following(known)
    elif low < 13:
        c = vertices[(seen[1] - 1 - low) & 15]
    elif low < 15:
        c = known[1] = known[1] + (low - (low ^ 3))
    else:
        c = _written_out(source, at, known)
        if c < 0:
            return False
    if low == 0 or low >= 13:
        _remember(vertices, seen, c)
    edges[seen[0] & 15] = c, b
    edges[(seen[0] + 1) & 15] = a, c
    seen[0] += 2
    result[t], result[t + 1], result[t + 2] = a, b, c
    return True


@njit(cache=True)
def _apart(source, token, at, seen, known, edges, vertices, result, t):  # type: ignore[no-untyped-def]
    """A triangle on no remembered edge: a pair of kinds, from the table at the end or in a byte, tells its corners."""
    end = len(source) - 16
    free = token >= 0xFE  # then a kind of 15 is a vertex written out
    if free:
        if at[1] >= end:
            return False
        pair = np.int64(source[at[1]])
        at[1] += 1
        if pair == 0:
            known[0] = 0
    else:
        pair = np.int64(source[end + (token & 15)])
    kinds = np.array([np.int64(15 if token == 0xFF else 0), pair >> 4, pair & 15])
    corners = np.zeros(3, dtype=np.int64)
    for k in range(3):
        if kinds[k] == 0:
            corners[k] = _following(known)
        elif kinds[k] < 15 or not free:
            corners[k] = vertices[(seen[1] - kinds[k]) & 15]
    for k in range(3):
        if free and kinds[k] == 15:
            corners[k] = _written_out(source, at, known)
            if corners[k] < 0:
                return False
    for k in range(3):
        if k == 0 or kinds[k] == 0 or (free and kinds[k] == 15):
            _remember(vertices, seen, corners[k])
    for k in range(3):
        edges[(seen[0] + k) & 15] = corners[(k + 1) % 3], corners[k]
        result[t + k] = corners[k]
    seen[0] += 3
    return True


@njit(cache=True)
def _following(known):  # type: ignore[no-untyped-def]
    known[0] += 1
    return known[0] - 1


@njit(cache=True)
def _written_out(source, at, known):  # type: ignore[no-untyped-def]
    """A vertex by its difference from the last one written out; -1 if the stream ends early."""
    value, after = _varint(source, at[1], len(source) - 16)
    if after < 0:
        return np.int64(-1)
    at[1] = after
    known[1] = _step(value, known[1])
    return known[1]


@njit(cache=True)
def _remember(vertices, seen, vertex):  # type: ignore[no-untyped-def]
    vertices[seen[1] & 15] = vertex
    seen[1] += 1
