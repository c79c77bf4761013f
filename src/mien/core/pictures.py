"""Pictures, judged by their size before they are decoded."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from mien.core.border import reading
from mien.core.limits import check_size, read_bytes

if TYPE_CHECKING:
    from PIL.Image import Image

__all__ = ["opened_picture"]


@contextmanager
def opened_picture(source: str | Path | bytes, where: object = None) -> Iterator[Image]:
    """A picture, not yet decoded; what goes wrong in opening or decoding it is one line.

    Parameters
    ----------
    source : path-like or bytes
    where : object, optional
        For messages, where ``source`` is bytes.

    Raises
    ------
    InputError
        If it is missing, no picture, damaged, or larger than the limit ``pixels``.
    """
    import PIL.Image

    where = source if where is None else where
    with reading(where, "a picture"):
        content = source if isinstance(source, bytes) else read_bytes(source)
        limit, PIL.Image.MAX_IMAGE_PIXELS = PIL.Image.MAX_IMAGE_PIXELS, None  # ours is judged just below
        try:
            with PIL.Image.open(io.BytesIO(content)) as picture:
                check_size("pixels", picture.width * picture.height, where)
                yield picture
        finally:
            PIL.Image.MAX_IMAGE_PIXELS = limit
