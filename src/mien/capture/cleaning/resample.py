"""Marker motion at another frame rate.

Upwards: a cubic spline through the samples, so that times that both rates share keep their values exactly.
Downwards: first everything above the new Nyquist frequency is taken out (windowed sinc, symmetric, so without delay;
the ends are continued by point reflection, so that constant and linear motion stay what they are), then the spline is
read.

A track of n frames covers n / fps seconds; the new track covers the same stretch (`FrameRate.frames_covering`). New
frames after the last old one, less than one old frame later, go on along the last step.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline

from mien.capture.cleaning.repairs import complete, runs
from mien.core.errors import InputError
from mien.core.timeline import FrameRate
from mien.core.tracks import MarkerTrack

__all__ = ["resample"]

_CUT = 0.9  # share of the new Nyquist frequency at which the filter has fallen to one half
_LOBES = 8  # zero crossings of the sinc on each side
_CLOSE = 1e-9  # of an old frame: two times this near are the same


def resample(track: MarkerTrack, rate: FrameRate) -> MarkerTrack:
    """The same motion at another rate.

    Parameters
    ----------
    track : MarkerTrack
        NaN where a marker was not seen: a new frame is NaN if one of the two old ones around it is.
    rate : FrameRate

    Raises
    ------
    InputError
        If the track has no frames.

    Examples
    --------
    >>> slow = MarkerTrack(("a",), np.arange(6.0).reshape(2, 1, 3), FrameRate.of(25))
    >>> resample(slow, FrameRate.of(50)).positions[:, 0, 0].tolist()
    [0.0, 1.5, 3.0, 4.5]
    """
    if rate == track.rate:
        return track
    if not len(track):
        raise InputError("marker track: it has no frames to resample")
    ratio = track.rate.fraction / rate.fraction
    count = rate.frames_covering(float(len(track) / track.rate.fraction))
    # In units of old frames, exact where the two rates meet.
    times = np.arange(count) * ratio.numerator / ratio.denominator
    positions = np.full((count, len(track.names), 3), np.nan)
    seen = complete(track.positions)
    for pattern in np.unique(seen, axis=1).T:
        alike = np.flatnonzero((seen == pattern[:, None]).all(axis=0))
        for first, last in runs(pattern):
            stretch = track.positions[first : last + 1][:, alike]
            if ratio > 1:
                stretch = _without_above(stretch, _CUT / float(ratio))
            # Only the end of the track is continued: beyond a gap's border nothing is known.
            limit = len(track) if last == len(track) - 1 else last + _CLOSE
            inside = np.flatnonzero((times >= first - _CLOSE) & (times <= limit))
            positions[np.ix_(inside, alike)] = _read(stretch, times[inside] - first)
    return MarkerTrack(track.names, positions, rate)


def _read(values: NDArray[np.float64], times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values (frames, ...) at fractional frames; past the last one along the last step."""
    if len(values) == 1:
        return np.repeat(values, len(times), axis=0)
    spline = make_interp_spline(np.arange(len(values)), values, k=3 if len(values) > 3 else 1)
    last = len(values) - 1
    result: NDArray[np.float64] = spline(np.clip(times, 0, last))
    beyond = (times > last)[:, None, None] * (times - last)[:, None, None]
    result = result + beyond * (values[-1] - values[-2])
    whole = np.round(times).astype(int)
    same = (np.abs(times - whole) < _CLOSE) & (whole <= last)
    result[same] = values[whole[same]]
    return result


def _without_above(values: NDArray[np.float64], cut: float) -> NDArray[np.float64]:
    """Low-pass along axis 0; ``cut`` is a share of the Nyquist frequency of ``values`` (0..1)."""
    reach = int(np.ceil(_LOBES / cut))
    steps = np.arange(-reach, reach + 1)
    taps = np.sinc(steps * cut) * np.kaiser(2 * reach + 1, 6.0)
    taps /= taps.sum()
    padded = _reflected(values, reach)
    length = len(values)
    result = np.zeros_like(values)
    for offset, tap in enumerate(taps):
        result += tap * padded[offset : offset + length]
    return result


def _reflected(values: NDArray[np.float64], reach: int) -> NDArray[np.float64]:
    """Values continued by point reflection at both ends, as often as the reach needs; one value is repeated."""
    if len(values) == 1:
        return np.repeat(values, 2 * reach + 1, axis=0)
    left = right = 0
    padded = values
    while left < reach or right < reach:
        step = min(reach - left, len(padded) - 1)
        head = 2 * padded[0] - padded[step:0:-1]
        tail = 2 * padded[-1] - padded[-2 : -2 - step : -1]
        padded = np.concatenate([head, padded, tail])
        left, right = left + step, right + step
    return padded
