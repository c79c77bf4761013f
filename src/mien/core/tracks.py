"""Motion over time: named channels and named markers, sampled at a fixed rate.

Validated when made, trusted afterwards: every fault is collected before one error is raised.
Arrays are float64, contiguous and read-only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mien.core.errors import InputError, unknown_name
from mien.core.timeline import FrameRate

__all__ = ["ChannelTrack", "MarkerTrack"]


def _checked(kind: str, names: Sequence[str], values: ArrayLike, shape: str, copy: bool = True) -> NDArray[np.float64]:
    array = np.array(values, dtype=np.float64, order="C") if copy else np.ascontiguousarray(values, dtype=np.float64)
    dimensions = shape.count(",") + 1
    faults = []
    if len(set(names)) != len(names):
        faults.append(f"names repeat: {sorted({n for n in names if list(names).count(n) > 1})}")
    if array.ndim != dimensions:
        faults.append(f"expected an array of shape {shape}, got {array.shape}")
    elif array.shape[1] != len(names):
        faults.append(f"{len(names)} names for {array.shape[1]} columns")
    if dimensions == 3 and array.ndim == 3 and array.shape[2] != 3:
        faults.append(f"a marker has three coordinates, got {array.shape[2]}")
    if dimensions == 2 and array.ndim == 2 and not np.isfinite(array).all():
        frame, column = np.argwhere(~np.isfinite(array))[0]
        faults.append(f"{array[frame, column]} in frame {frame}, channel {names[column]!r}")
    if faults:
        raise InputError(f"{kind}: " + "; ".join(faults))
    array.setflags(write=False)
    return array


@dataclass(frozen=True, eq=False)
class ChannelTrack:
    """Named channels over time.

    Parameters
    ----------
    names : sequence of str
        Channel names, each once.
    values : array_like, shape (frames, channels)
        Finite numbers; the meaning and range of each channel is said in `mien.core.channels`.
    rate : FrameRate

    Raises
    ------
    InputError
        If shape, names or numbers do not fit; the message lists every fault.

    Examples
    --------
    >>> track = ChannelTrack(("jawOpen",), [[0.0], [0.5]], FrameRate.of(25))
    >>> float(track.channel("jawOpen")[1])
    0.5
    """

    names: tuple[str, ...]
    values: NDArray[np.float64]
    rate: FrameRate

    def __init__(self, names: Sequence[str], values: ArrayLike, rate: FrameRate) -> None:
        object.__setattr__(self, "names", tuple(names))
        object.__setattr__(self, "values", _checked("channel track", names, values, "(frames, channels)"))
        object.__setattr__(self, "rate", rate)

    @classmethod
    def taking(cls, names: Sequence[str], values: NDArray[np.float64], rate: FrameRate) -> ChannelTrack:
        """A track that takes an array over, which nobody may change then: an hour is not held twice.

        Examples
        --------
        >>> own = np.zeros((2, 1))
        >>> ChannelTrack.taking(("jawOpen",), own, FrameRate.of(25)).values is own
        True
        """
        found = cls.__new__(cls)
        object.__setattr__(found, "names", tuple(names))
        object.__setattr__(found, "values", _checked("channel track", names, values, "(frames, channels)", copy=False))
        object.__setattr__(found, "rate", rate)
        return found

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, ChannelTrack)
            and self.names == other.names
            and self.rate == other.rate
            and np.array_equal(self.values, other.values)
        )

    def __len__(self) -> int:
        return len(self.values)

    def channel(self, name: str) -> NDArray[np.float64]:
        """One channel, shape (frames,)."""
        if name not in self.names:
            raise unknown_name("channel", name, self.names)
        return self.values[:, self.names.index(name)]

    def select(self, names: Sequence[str]) -> ChannelTrack:
        """The named channels in the given order; a channel that the track lacks is zero."""
        values = np.zeros((len(self), len(names)))
        for column, name in enumerate(names):
            if name in self.names:
                values[:, column] = self.values[:, self.names.index(name)]
        return ChannelTrack.taking(names, values, self.rate)


@dataclass(frozen=True, eq=False)
class MarkerTrack:
    """Named markers over time, in millimetres; x to the speaker's left, y up, z forward.

    Parameters
    ----------
    names : sequence of str
        Marker names, each once.
    positions : array_like, shape (frames, markers, 3)
        Millimetres; NaN where a marker was not seen.
    rate : FrameRate

    Raises
    ------
    InputError
        If shape or names do not fit; the message lists every fault.
    """

    names: tuple[str, ...]
    positions: NDArray[np.float64]
    rate: FrameRate

    def __init__(self, names: Sequence[str], positions: ArrayLike, rate: FrameRate) -> None:
        object.__setattr__(self, "names", tuple(names))
        object.__setattr__(self, "positions", _checked("marker track", names, positions, "(frames, markers, 3)"))
        object.__setattr__(self, "rate", rate)

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, MarkerTrack)
            and self.names == other.names
            and self.rate == other.rate
            and np.array_equal(self.positions, other.positions, equal_nan=True)
        )

    def __len__(self) -> int:
        return len(self.positions)
