"""Swaps: two markers that exchanged names for a stretch, and get them back.

A tracker that loses two markers near each other may take up each as the other. Then the line from one to the other
points the wrong way (against its median over the take) for the whole stretch, and at its first and last frame both
markers jump by about their distance. Both are asked for: a stretch is undone only if the line is turned by more than
`SwapSettings.turned`, and if exchanging the names makes the jumps at its borders smaller by the factor
`SwapSettings.gain` at least. Lips that meet and part again do neither.

A swap that lasts for more than half of a take cannot be told from the rest being swapped; give the ``rest`` pose of
another take to know which is right.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.capture.cleaning.repairs import Repair, complete, runs
from mien.core.errors import InputError
from mien.core.tracks import MarkerTrack

__all__ = ["SwapSettings", "mend_swaps"]

_CHUNK = 64  # frames per step: keeps the table of pairs small


@dataclass(frozen=True)
class SwapSettings:
    """What counts as a swap.

    Attributes
    ----------
    turned : float
        How far the line between two markers must point backwards, as a share of its median length (0..1).
    gain : float
        Factor by which undoing must shorten the jumps at the borders.
    apart : float
        Least median distance of two markers that can be told apart, mm.
    """

    turned: float = 0.5
    gain: float = 3.0
    apart: float = 2.0


def mend_swaps(
    track: MarkerTrack, settings: SwapSettings | None = None, rest: NDArray[np.float64] | None = None
) -> tuple[MarkerTrack, tuple[Repair, ...]]:
    """Give markers that were exchanged for a stretch their names back.

    Parameters
    ----------
    track : MarkerTrack
        Normalised, mm.
    settings : SwapSettings, optional
    rest : ndarray, shape (markers, 3), optional
        A pose known to be right; the default is the median of the track.

    Raises
    ------
    InputError
        If ``rest`` has other markers.
    """
    settings = settings or SwapSettings()
    if rest is not None and rest.shape != track.positions.shape[1:]:
        raise InputError(f"rest pose: expected shape ({len(track.names)}, 3), got {rest.shape}")
    seen = complete(track.positions)
    known = seen.any(axis=0)
    middle = np.full((len(track.names), 3), np.nan) if rest is None else rest.copy()
    if rest is None:
        middle[known] = np.nanmedian(track.positions[:, known], axis=0)
    positions = track.positions.copy()
    repairs = []
    # The most clearly turned pair goes first: a swap also turns some lines to neighbours, which undoing puts right.
    for _, one, other in sorted(_turned_pairs(positions, middle, settings)):
        for first, last in _stretches(positions, middle, one, other, settings):
            stretch = slice(first, last + 1)
            positions[stretch, [one, other]] = positions[stretch, [other, one]]
            repairs.append(Repair("swap", (track.names[one], track.names[other]), first, last, "names exchanged back"))
    repairs.sort(key=lambda repair: (repair.first, repair.markers))
    return MarkerTrack(track.names, positions, track.rate), tuple(repairs)


def _turned_pairs(
    positions: NDArray[np.float64], middle: NDArray[np.float64], settings: SwapSettings
) -> list[tuple[float, int, int]]:
    """Pairs of markers whose line is turned in some frame: (most negative turn, one, other)."""
    gaps = ((middle[:, None] - middle[None]) ** 2).sum(axis=2)
    least = np.full(gaps.shape, np.inf)
    for start in range(0, len(positions), _CHUNK):
        # The scalar product of a pair's line with its median line, from the products of all with all.
        products = np.einsum("fik,jk->fij", positions[start : start + _CHUNK], middle)
        own = np.diagonal(products, axis1=1, axis2=2)
        turn = own[:, :, None] + own[:, None, :] - products - products.transpose(0, 2, 1)
        turn[np.isnan(turn)] = np.inf
        least = np.minimum(least, turn.min(axis=0))
    gaps[~(gaps >= settings.apart**2)] = np.nan
    with np.errstate(invalid="ignore"):
        share = least / gaps
        found = np.argwhere(np.triu(share < -settings.turned, k=1))
    return [(float(share[i, j]), int(i), int(j)) for i, j in found]


def _stretches(
    positions: NDArray[np.float64], middle: NDArray[np.float64], one: int, other: int, settings: SwapSettings
) -> list[tuple[int, int]]:
    """Stretches of frames in which a pair is swapped."""
    line = middle[one] - middle[other]
    turn = (positions[:, one] - positions[:, other]) @ line / float(line @ line)
    with np.errstate(invalid="ignore"):
        backwards = turn < 0
        clear = turn < -settings.turned
    found = []
    for first, last in runs(_bridged(backwards, np.isnan(turn))):
        inside = clear[first : last + 1] & backwards[first : last + 1]
        if inside.any() and _heals(positions, one, other, first, last, settings.gain):
            found.append((first, last))
    return found


def _bridged(flags: NDArray[np.bool_], unknown: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Flags with unknown frames between two flagged ones flagged too."""
    result = flags.copy()
    for first, last in runs(unknown):
        if first > 0 and last < len(flags) - 1:
            result[first : last + 1] = flags[first - 1] and flags[last + 1]
    return result


def _heals(positions: NDArray[np.float64], one: int, other: int, first: int, last: int, gain: float) -> bool:
    """Whether exchanging a pair in a stretch shortens the jumps at its borders by ``gain``."""
    pair = positions[:, [one, other]]
    seen = complete(pair, 2)
    inner = first + np.flatnonzero(seen[first : last + 1])
    before, after = np.flatnonzero(seen[:first]), last + 1 + np.flatnonzero(seen[last + 1 :])
    borders = [(before[-1], inner[0])] if before.size else []
    borders += [(after[0], inner[-1])] if after.size else []
    as_is = [float(np.linalg.norm(pair[a] - pair[b], axis=1).sum()) for a, b in borders]
    undone = [float(np.linalg.norm(pair[a] - pair[b][::-1], axis=1).sum()) for a, b in borders]
    return bool(borders) and all(old > gain * new for old, new in zip(as_is, undone, strict=True))
