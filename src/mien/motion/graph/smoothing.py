"""Low-pass filtering of joined motion, with cut-offs learned from recorded motion (Cao et al. 2005, 4.3).

For each independent component the cut-off is the frequency below which 99 % of the energy of all recorded motion lies.
The filter runs forwards and backwards, so that nothing is delayed.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

__all__ = ["ENERGY", "learned_cut_offs", "low_passed"]

ENERGY = 0.99
"""Share of the energy below the cut-off."""
_DAMPINGS = (2 * np.sin(np.pi / 8), 2 * np.sin(3 * np.pi / 8))  # of the two pairs of poles of a fourth order
_FLOOR = 0.5  # Hz
_BLOCK = 4096  # frames

Floats = NDArray[np.float64]


def learned_cut_offs(motions: Sequence[Floats], fps: float, energy: float = ENERGY) -> Floats:
    """Frequency below which ``energy`` of the energy of each component lies, Hz, shape (components,).

    Parameters
    ----------
    motions : sequence of ndarray, shape (frames, components)
        Unbroken stretches of recorded motion; those shorter than eight frames tell nothing. The mean of each is taken
        out and its ends are faded (Hann), so that they do not count as motion.
    fps : float

    Examples
    --------
    >>> wave = np.sin(2 * np.pi * 3.0 * np.arange(500) / 25)[:, None]
    >>> bool(2.9 < learned_cut_offs([wave], 25.0)[0] < 3.2)
    True
    """
    half = fps / 2
    grid = np.linspace(0, half, 513)
    total = np.zeros((len(grid), motions[0].shape[1] if motions else 0))
    for motion in motions:
        if len(motion) < 8:
            continue
        centred = (motion - motion.mean(axis=0)) * np.hanning(len(motion))[:, None]
        power = np.abs(np.fft.rfft(centred, 1024 if len(motion) <= 1024 else len(motion), axis=0)) ** 2
        steps = np.linspace(0, half, len(power))
        total += np.stack([np.interp(grid, steps, column) for column in power.T], axis=1)
    held = np.cumsum(total, axis=0)
    whole = held[-1]
    reached = [int(np.searchsorted(column, energy * all_)) for column, all_ in zip(held.T, whole, strict=True)]
    found = np.where(whole > 0, grid[np.minimum(reached, len(grid) - 1)], half)
    return np.asarray(np.maximum(found, _FLOOR))


def low_passed(components: Floats, fps: float, cut_offs: Floats) -> Floats:
    """Components without what is faster than the cut-offs, shape (frames, components) in and out.

    A Butterworth filter of fourth order, forwards and backwards: half the amplitude at the cut-off, no delay. A cut-off
    at or beyond half the rate leaves its component alone.

    Examples
    --------
    >>> times = np.arange(200) / 100
    >>> slow, fast = np.sin(2 * np.pi * times), np.sin(2 * np.pi * 30 * times)
    >>> left = low_passed((slow + fast)[:, None], 100.0, np.array([8.0]))[:, 0]
    >>> bool(np.abs(left - slow)[20:-20].max() < 0.02)
    True
    """
    if len(components) < 4:
        return components.copy()
    reach = min(len(components) - 1, round(fps))
    fast = np.flatnonzero(cut_offs < 0.95 * fps / 2)
    held = components[:, fast]
    padded = np.concatenate([2 * held[0] - held[reach:0:-1], held, 2 * held[-1] - held[-2 : -reach - 2 : -1]])
    del held
    warped = np.tan(np.pi * cut_offs[fast] / fps)
    _filter(padded, warped)
    _filter(padded[::-1], warped)
    result = components.copy()
    result[:, fast] = padded[reach : reach + len(components)]
    return result


def _filter(values: Floats, warped: Floats) -> None:
    """A Butterworth filter of fourth order down each column, in place, as if its first value had always been there.

    Two sections of second order by the bilinear transform (Oppenheim & Schafer 2010, section 7.2), ``warped`` =
    tan(pi cut-off / rate), shape (columns,). Written out, since importing scipy.signal takes longer than all else that
    a line needs.
    """
    for damping in _DAMPINGS:
        scale = 1 / (1 + damping * warped + warped**2)
        ahead, first = warped**2 * scale, 2 * (warped**2 - 1) * scale
        second = (1 - damping * warped + warped**2) * scale
        near, far = values[0] * (1 - ahead), values[0] * (ahead - second)
        for start in range(0, len(values), _BLOCK):
            for place, now in enumerate(ahead * values[start : start + _BLOCK], start):
                out = now + near
                near = 2 * now - first * out + far
                far = now - second * out
                values[place] = out
