"""Memory of long sounds: arrays that lie in a nameless temporary file, and giving back what is free.

The system keeps as much of such a file in memory as it likes. `let_go` says that a part is not needed for now: it is
read again when somebody looks. An hour of sound takes 230 MB at 16 kHz, and most of the work on it looks at seconds.
"""

from __future__ import annotations

import ctypes
import sys
import tempfile
from functools import cache
from mmap import mmap
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["LONG", "GrowingSound", "let_go", "long_array", "trim"]

LONG = 600
"""Seconds from which on a sound is long."""


def long_array(count: int) -> NDArray[np.float32]:
    """An array of so many zeros whose place is on the disk.

    Examples
    --------
    >>> found = long_array(4)
    >>> found[1] = 2
    >>> let_go(found)
    >>> found.tolist()
    [0.0, 2.0, 0.0, 0.0]
    """
    with tempfile.TemporaryFile() as file:
        file.truncate(4 * max(count, 1))
        return np.frombuffer(mmap(file.fileno(), 0), np.float32, count)


class GrowingSound:
    """A sound that is made piece by piece; once it is `LONG` what there is of it goes to the disk.

    Parameters
    ----------
    rate : int
        Samples per second.

    Examples
    --------
    >>> sound = GrowingSound(8000)
    >>> sound.add(np.array([0.5, 0.25]))
    >>> sound.add(np.zeros(1))
    >>> len(sound), sound.taken().tolist()
    (3, [0.5, 0.25, 0.0])
    """

    def __init__(self, rate: int) -> None:
        self._rate, self._count = rate, 0
        self._pieces: list[NDArray[np.float32]] = []
        self._file: IO[bytes] | None = None

    def __len__(self) -> int:
        return self._count

    def add(self, samples: NDArray[np.floating]) -> None:
        """Go on with some samples."""
        self._pieces.append(samples.astype(np.float32))
        self._count += len(samples)
        if self._file is None and self._count > LONG * self._rate:
            self._file = tempfile.TemporaryFile()  # noqa: SIM115  # closed when it is taken
        if self._file is not None:
            for piece in self._pieces:
                self._file.write(piece.tobytes())
            self._pieces.clear()

    def taken(self) -> NDArray[np.float32]:
        """All of it, to be changed by who takes it; nothing is left here."""
        pieces, self._pieces = self._pieces, []
        if self._file is None:
            return np.concatenate(pieces) if pieces else np.zeros(0, np.float32)
        with self._file as file:
            file.flush()
            return np.frombuffer(mmap(file.fileno(), 0), np.float32, self._count)


def let_go(array: NDArray[Any]) -> None:
    """Take what is in memory of a `long_array` (or a part of one) out of it; nothing happens to any other array."""
    holder: Any = array
    while isinstance(holder, (np.ndarray, memoryview)):
        holder = holder.obj if isinstance(holder, memoryview) else holder.base
    if isinstance(holder, mmap) and sys.platform == "linux":
        import mmap as constants

        holder.madvise(constants.MADV_DONTNEED)


def trim() -> None:
    """Give free memory back to the system: the C library keeps what lies between things that are still used."""
    if (library := _c_library()) is not None:
        library.malloc_trim(0)


@cache
def _c_library() -> Any:
    library = ctypes.CDLL(None) if sys.platform == "linux" else None
    return library if hasattr(library, "malloc_trim") else None
