"""What every reader gives: a recording as its files have it, before any cleaning."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mien.core.audio import Audio
from mien.core.border import reading
from mien.core.errors import Note
from mien.core.tracks import ChannelTrack, MarkerTrack
from mien.corpus.recipes import Recipe

__all__ = ["Found", "Raw", "Reader"]


@dataclass(frozen=True)
class Found:
    """A recording that a reader found: where its parts lie.

    Attributes
    ----------
    name : str
        As the files say; may repeat in other folders.
    motion : Path
        File with the motion. Several recordings may share one.
    sound, transcript : Path or None
        Files beside it; a reader may find sound inside ``motion`` too.
    """

    name: str
    motion: Path
    sound: Path | None = None
    transcript: Path | None = None

    @property
    def files(self) -> tuple[Path, ...]:
        """All files of the recording."""
        return tuple(path for path in (self.motion, self.sound, self.transcript) if path is not None)


@dataclass(frozen=True, eq=False)
class Raw:
    """A recording as its files have it.

    Attributes
    ----------
    markers : MarkerTrack
        In ``units``; NaN where a marker was not seen.
    units : str
        ``"pixels"`` (x right, y down, z negative towards the camera), ``"mm"``, ``"cm"``, ``"m"``; ``""``: not known.
    audio : Audio or None
    channels : ChannelTrack or None
        ARKit weights where the recording has them.
    head : ndarray, shape (frames, 4, 4), or None
        Given if the reader took the head's motion out itself; the markers then are in the face's axes.
    notes : tuple of Note
    """

    markers: MarkerTrack
    units: str
    audio: Audio | None = None
    channels: ChannelTrack | None = None
    head: NDArray[np.float64] | None = None
    notes: tuple[Note, ...] = field(default=())


@dataclass(frozen=True)
class Reader:
    """One kind of source.

    Attributes
    ----------
    name, about : str
    recognises : callable
        Whether a folder or file is of this kind; looks at names and first lines only.
    find : callable
        The recordings in a source, in order of their names.
    reading : callable
        One recording, as `read` gives it.
    needs : callable, optional
        Raises MissingPartError early if a part for this reader is not installed.
    """

    name: str
    about: str
    recognises: Callable[[Path], bool]
    find: Callable[[Path], list[Found]]
    reading: Callable[[Found, Recipe], Raw]
    needs: Callable[[], None] = lambda: None

    def read(self, found: Found, recipe: Recipe) -> Raw:
        """One recording.

        Raises
        ------
        InputError
            In one line that names the file, and the frame where there is one.
        """
        with reading(found.motion, f"a recording ({self.name})"):
            return self.reading(found, recipe)
