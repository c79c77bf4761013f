"""Speech shaped period by period: other times and another pitch, with formants where they were (TD-PSOLA).

Moulines & Charpentier 1990 (Speech Communication 9): the sound is cut at pitch marks into windows of two periods, which
are laid down again as far apart as the new pitch asks. Where there is no voice, windows are 5 ms apart and only time
changes. `mien.speech.sound_reshaping` (WSOLA) moves formants along with pitch; a voice that feels must not shrink.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.speech.pitch import PitchContour

__all__ = ["PitchMarks", "pitch_marks", "repitched"]

Floats = NDArray[np.float64]
_UNVOICED = 0.005  # seconds between two windows where there is no voice
_SEARCH = 0.2  # of a period: how far a mark may lie from where the contour has it


@dataclass(frozen=True, eq=False)
class PitchMarks:
    """Where windows are centred.

    Attributes
    ----------
    places : ndarray of int, shape (marks,)
        Samples, rising.
    voiced : ndarray of bool, shape (marks,)
    """

    places: NDArray[np.int64]
    voiced: NDArray[np.bool_]


def pitch_marks(samples: Floats, rate: int, pitch: PitchContour) -> PitchMarks:
    """One mark for each period of a voice, at alike points of the wave, and one every 5 ms elsewhere.

    Examples
    --------
    >>> from mien.core.audio import Audio
    >>> from mien.speech.pitch import pitch_contour
    >>> hum = Audio(0.2 * np.sin(2 * np.pi * 200 * np.arange(16000) / 16000), 16000)
    >>> marks = pitch_marks(hum.samples.astype(float), 16000, pitch_contour(hum))
    >>> int(np.median(np.diff(marks.places[marks.voiced])))
    80
    """
    places, voiced = [0], [False]
    for start, end in _voiced_runs(pitch):
        first, after = round(start * rate), min(round(end * rate), len(samples))
        _fill(places, voiced, first, round(_UNVOICED * rate))
        for place in _periods(samples, rate, pitch, max(first, places[-1] + 1), after):
            places.append(place)
            voiced.append(True)
    _fill(places, voiced, len(samples), round(_UNVOICED * rate))
    return PitchMarks(np.array(places), np.array(voiced))


def _fill(places: list[int], voiced: list[bool], end: int, step: int) -> None:
    while places[-1] + 1.5 * step < end:
        places.append(places[-1] + step)
        voiced.append(False)


def _voiced_runs(pitch: PitchContour) -> list[tuple[float, float]]:
    edges = np.diff(np.concatenate(([0], pitch.voiced.astype(int), [0])))
    half = (pitch.times[1] - pitch.times[0]) / 2 if len(pitch) > 1 else 0.0
    starts, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1
    pairs = zip(starts, ends, strict=True)
    return [(max(0.0, float(pitch.times[a] - half)), float(pitch.times[b] + half)) for a, b in pairs]


def _periods(samples: Floats, rate: int, pitch: PitchContour, first: int, after: int) -> list[int]:
    """Marks of one voiced run: the first at its loudest point, each next where the wave looks most like the last."""
    period = _period(pitch, first / rate, rate)
    if after - first < 2 * period:
        return []
    last = first + int(np.argmax(np.abs(samples[first : first + period])))
    found = [last]
    while True:
        period = _period(pitch, last / rate, rate)
        search, half = max(1, round(_SEARCH * period)), period // 2
        expected = last + period
        if expected + search + half >= min(after + period, len(samples)) or expected > after:
            return found
        if last - half >= 0:
            area = samples[expected - search - half : expected + search + half]
            likeness = np.correlate(area, samples[last - half : last + half], "valid")
            energy = np.convolve(area * area, np.ones(2 * half), "valid")
            expected += int(np.argmax(likeness / np.sqrt(energy + 1e-9))) - search
        last = expected
        found.append(last)


def _period(pitch: PitchContour, seconds: float, rate: int) -> int:
    return max(2, round(rate / float(pitch.hertz_at(seconds))))


def repitched(samples: Floats, rate: int, marks: PitchMarks, old: Floats, new: Floats, factor: Floats) -> Floats:
    """Sound whose instants ``old`` lie at ``new``, its pitch ``factor`` times as high there.

    Parameters
    ----------
    samples : ndarray, shape (samples,)
    rate : int
    marks : PitchMarks
    old, new : ndarray, shape (instants,)
        Seconds, rising, from 0.
    factor : ndarray, shape (instants,)
        At the instants.

    Returns
    -------
    ndarray, shape (round(new[-1] * rate),)
    """
    count, places = round(float(new[-1]) * rate), marks.places
    gaps = np.diff(places, prepend=places[0] - (places[1] - places[0]), append=2 * places[-1] - places[-2])
    reach = int(gaps.max()) + 1
    padded = np.pad(samples, reach)
    result, weight = np.zeros(count + 2 * reach), np.zeros(count + 2 * reach)
    now, last = 0.0, -1
    middles = (places[1:] + places[:-1]) / 2
    while now < count:
        seconds = now / rate
        before = float(np.interp(seconds, new, old))
        mark = int(np.searchsorted(middles, before * rate))
        left, right = int(gaps[mark]), int(gaps[mark + 1])
        window = padded[reach + places[mark] - left : reach + places[mark] + right] * _shape(left, right)
        if mark == last and not marks.voiced[mark] and left == right:
            window = window[::-1]  # noise said twice turns into a tone: the second time backwards
            last = -1
        else:
            last = mark
        at = reach + round(now)
        result[at - left : at + right] += window
        weight[at - left : at + right] += _shape(left, right)
        now += right / float(np.interp(before, old, factor)) if marks.voiced[mark] else right
    return np.asarray((result / np.maximum(weight, 1.0))[reach : reach + count])


def _shape(left: int, right: int) -> Floats:
    """A window that rises over ``left`` samples and falls over ``right``."""
    up = 0.5 - 0.5 * np.cos(np.pi * (np.arange(left) + 0.5) / left)
    down = 0.5 + 0.5 * np.cos(np.pi * (np.arange(right) + 0.5) / right)
    return np.concatenate([up, down])
