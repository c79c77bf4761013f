"""Pictures in KTX2 with Basis Universal's supercompression (ETC1S, UASTC), through its transcoder (an extra).

Source: KHR_texture_basisu; KTX 2.0 specification, section 3 (header).
"""

from __future__ import annotations

import struct
from importlib.util import find_spec

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.core.limits import check_size

__all__ = ["is_ktx2", "ktx2_pixels"]

_MAGIC = b"\xabKTX 20\xbb\r\n\x1a\n"


def is_ktx2(data: bytes) -> bool:
    """Whether bytes begin as a KTX2 file does."""
    return data.startswith(_MAGIC)


def ktx2_pixels(data: bytes, what: str, largest: int) -> NDArray[np.uint8]:
    """Pixels (height, width, 4) of the largest level whose sides are ``largest`` at most (or of the smallest level).

    Raises
    ------
    InputError
        If the transcoder is not installed or the data cannot be read; ``what`` names the picture.
    """
    if not find_spec("opengl_basisu"):
        raise InputError("it is KTX2, whose decoder is an extra: pip install 'mien[files]'")
    if len(data) < 48:
        raise InputError(f"{what} is cut off")
    wide, tall, _, layers, _, levels = struct.unpack_from("<6I", data, 20)
    check_size("pixels", max(wide, 1) * max(tall, 1), what)
    check_size("pixels", max(wide, 1) * max(tall, 1) * max(layers, 1), what)
    import opengl_basisu

    level = 0
    while max(wide, tall) >> level > largest and level + 1 < levels:
        level += 1
    try:
        image = opengl_basisu.open(data).transcode(opengl_basisu.Target.RGBA8, level=level)
        pixels = np.array(image.data, dtype=np.uint8)
    except (ValueError, RuntimeError, MemoryError) as problem:
        raise InputError(f"{what} cannot be decoded as KTX2 ({problem})") from problem
    return pixels.reshape(image.height, image.width, 4)
