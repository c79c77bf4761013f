"""Readers of recordings: one module per kind of source, all held to one contract (`raw.Reader`)."""

from __future__ import annotations

from pathlib import Path

from mien.corpus.readers import c3d, grid, livelink, tracks, video
from mien.corpus.readers.raw import Found, Raw, Reader
from mien.errors import InputError, unknown_name

__all__ = ["READERS", "Found", "Raw", "Reader", "detect", "reader_named"]

READERS: tuple[Reader, ...] = (grid.READER, c3d.READER, livelink.READER, tracks.READER, video.READER)
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
    kinds = "; ".join(reader.about for reader in READERS)
    raise InputError(f"{source}: no recording found that mien knows; expected {kinds}")
