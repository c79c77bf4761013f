"""Readers of recordings: one module per kind of source, all held to one contract (`raw.Reader`)."""

from __future__ import annotations

from pathlib import Path

from mien.core.errors import InputError, unknown_name
from mien.corpus.readers import (
    beat_recordings as beat,
)
from mien.corpus.readers import (
    c3d_recordings as c3d,
)
from mien.corpus.readers import (
    grid_recordings as grid,
)
from mien.corpus.readers import (
    livelink_recordings as livelink,
)
from mien.corpus.readers import (
    marker_tables as tracks,
)
from mien.corpus.readers import (
    mesh_recordings as meshes,
)
from mien.corpus.readers import (
    video_recordings as video,
)
from mien.corpus.readers.raw_recordings import Found, Raw, Reader

__all__ = ["READERS", "Found", "Raw", "Reader", "detect", "reader_named"]

READERS: tuple[Reader, ...] = (
    *(grid.READER, beat.READER, c3d.READER, livelink.READER, tracks.READER, video.READER, meshes.READER),
)
"""In the order in which a source is held against them."""


def reader_named(name: str) -> Reader:
    """The reader of that name.

    Raises
    ------
    InputError
        If there is none.

    Examples
    --------
    >>> reader_named("c3d").name
    'c3d'
    """
    for reader in READERS:
        if reader.name == name:
            return reader
    raise unknown_name("reader", name, [reader.name for reader in READERS])


def detect(source: Path) -> Reader:
    """The reader that recognises a source.

    Raises
    ------
    InputError
        If none does; the message says what is expected.
    """
    for reader in READERS:
        if reader.recognises(source):
            return reader
    names = ", ".join(reader.name for reader in READERS)
    raise InputError(f"{source}: no recording found that mien knows; expected one of {names} (docs/corpus.md)")
