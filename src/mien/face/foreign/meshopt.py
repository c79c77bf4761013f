"""EXT_meshopt_compression decoded: attributes, triangles and indices, and the exponential filter.

Source: EXT_meshopt_compression, appendices A (bitstreams) and B (filters), Khronos glTF extension registry. Of the
attributes' codec version 0 is known; the filters for normals and rotations are not needed to draw and are refused.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

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
    code, at, end = 1, 1 + count // 3, len(source) - 16
    edges = np.zeros((16, 2), dtype=np.int64)
    vertices = np.zeros(16, dtype=np.int64)
    edge = vertex = 0
    following = last = np.int64(0)
    for t in range(0, count, 3):
        token = int(source[code])
        code += 1
        if token < 0xF0:
            a, b = edges[(edge - 1 - (token >> 4)) & 15]
            low = token & 15
            fresh = True
            if low == 0:
                c = following
                following += 1
            elif low < 13:
                c = vertices[(vertex - 1 - low) & 15]
                fresh = False
            elif low < 15:
                c = last + (low - (low ^ 3))
                last = c
            else:
                value, at = _varint(source, at, end)
                if at < 0:
                    return False
                c = _step(value, last)
                last = c
            if fresh:
                vertices[vertex & 15] = c
                vertex += 1
            edges[edge & 15] = c, b
            edges[(edge + 1) & 15] = a, c
            edge += 2
        else:
            if token < 0xFE:
                pair, a_kind = int(source[end + (token & 15)]), 0
            else:
                if at >= end:
                    return False
                pair, a_kind = int(source[at]), 0 if token == 0xFE else 15
                at += 1
                if pair == 0:
                    following = np.int64(0)
            b_kind, c_kind = pair >> 4, pair & 15
            a = b = c = np.int64(0)
            if a_kind == 0:
                a = following
                following += 1
            if b_kind == 0:
                b = following
                following += 1
            elif b_kind < 15 or token < 0xFE:
                b = vertices[(vertex - b_kind) & 15]
            if c_kind == 0:
                c = following
                following += 1
            elif c_kind < 15 or token < 0xFE:
                c = vertices[(vertex - c_kind) & 15]
            if token >= 0xFE:
                if a_kind == 15:
                    value, at = _varint(source, at, end)
                    if at < 0:
                        return False
                    a = last = _step(value, last)
                if b_kind == 15:
                    value, at = _varint(source, at, end)
                    if at < 0:
                        return False
                    b = last = _step(value, last)
                if c_kind == 15:
                    value, at = _varint(source, at, end)
                    if at < 0:
                        return False
                    c = last = _step(value, last)
            vertices[vertex & 15] = a
            vertex += 1
            if b_kind == 0 or (b_kind == 15 and token >= 0xFE):
                vertices[vertex & 15] = b
                vertex += 1
            if c_kind == 0 or (c_kind == 15 and token >= 0xFE):
                vertices[vertex & 15] = c
                vertex += 1
            edges[edge & 15] = b, a
            edges[(edge + 1) & 15] = c, b
            edges[(edge + 2) & 15] = a, c
            edge += 3
        result[t], result[t + 1], result[t + 2] = a, b, c
    return True
