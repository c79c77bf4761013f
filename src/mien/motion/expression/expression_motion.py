"""Expressive recordings without their words: warp, subtract (Deng et al. 2006, section VI).

The same sentence, said with an emotion and without, differs by the emotion and by its timing. The expressive take is
warped onto its neutral twin phone by phone (takes without phone times: by the motion of the mouth); then the neutral
motion is subtracted, and expressive motion that no longer depends on the phones is left.

On the mouth the neutral *frames* are subtracted, on the upper face only the neutral *mean*: its motion hardly depends
on the phones, and subtracting another take's wanderings would add them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from mien.capture.layouts import load_layout
from mien.core.errors import InputError
from mien.core.timeline import Tier
from mien.core.utterance import PAUSE
from mien.corpus.take import Take
from mien.motion.expression.expression_space import RATE

__all__ = [
    "Twins",
    "expressive_displacement",
    "find_twins",
    "matched_phones",
    "warped_by_motion",
    "warped_times",
]

Floats = NDArray[np.float64]
_GRID = 60.0
_ALIKE = 0.5
LEAST_MATCHED = 0.6
"""Share of the phones of both takes that must be matched: below it they do not say the same."""


@dataclass(frozen=True, eq=False)
class Twins:
    """A take with an emotion and the same sentence without."""

    expressive: Take
    neutral: Take


def find_twins(takes: Sequence[Take]) -> tuple[Twins, ...]:
    """Pair every expressive take with the neutral take of the same sentence and speaker (the nearest in length)."""
    neutral = sorted((t for t in takes if t.emotion in ("", "neutral")), key=_said)
    by_sentence = {said: list(group) for said, group in groupby(neutral, key=_said)}
    pairs = []
    for take in takes:
        if take.emotion not in ("", "neutral") and _said(take) in by_sentence:
            twins = by_sentence[_said(take)]
            pairs.append(Twins(take, min(twins, key=lambda twin: (abs(twin.duration - take.duration), twin.name))))
    return tuple(pairs)


def _said(take: Take) -> tuple[str, str]:
    """What makes two takes say the same: the corpus's sentence, or else the words."""
    return take.speaker, take.sentence or " ".join(word.label.lower() for word in take.words)


def matched_phones(phones: Tier, others: Tier) -> list[tuple[int, int]]:
    """Pairs of phones that are the same in two tiers, in order: the longest common run of labels.

    Examples
    --------
    >>> from mien.core.timeline import Interval
    >>> said = Tier("phones", (Interval(0, 1, "HH"), Interval(1, 2, "AY")))
    >>> again = Tier("phones", (Interval(0, 1, "SIL"), Interval(1, 2, "HH"), Interval(2, 3, "AY")))
    >>> matched_phones(said, again)
    [(0, 1), (1, 2)]
    """
    first, second = [p.label for p in phones], [p.label for p in others]
    best = np.zeros((len(first) + 1, len(second) + 1), dtype=np.int64)
    for i in range(len(first) - 1, -1, -1):
        for j in range(len(second) - 1, -1, -1):
            same = best[i + 1, j + 1] + 1 if first[i] == second[j] else 0
            best[i, j] = max(best[i + 1, j], best[i, j + 1], same)
    pairs, i, j = [], 0, 0
    while i < len(first) and j < len(second):
        if first[i] == second[j] and best[i, j] == best[i + 1, j + 1] + 1:
            pairs.append((i, j))
            i, j = i + 1, j + 1
        elif best[i + 1, j] >= best[i, j + 1]:
            i += 1
        else:
            j += 1
    return pairs


def warped_times(times: Floats, onto: Tier, source: Tier) -> Floats:
    """Where each instant of one take lies in another take of the same words, shape (times,), seconds.

    Inside a phone that both say, time runs evenly from its start to its end; between matched phones evenly from one to
    the next. Outside the speech time runs as it is.

    Raises
    ------
    InputError
        If the two do not say the same.
    """
    pairs = matched_phones(onto, source)
    spoken = [sum(phone.label != PAUSE for phone in tier) for tier in (onto, source)]
    said = [(i, j) for i, j in pairs if onto.intervals[i].label != PAUSE]
    if not said or len(said) < LEAST_MATCHED * max(spoken):
        raise InputError(
            f"expected the same sentence in both takes, but only {len(said)} of {max(spoken)} phones are the same"
        )
    knots: list[tuple[float, float]] = []
    for i, j in said:
        here, there = onto.intervals[i], source.intervals[j]
        knots += [(here.start, there.start), (here.end, there.end)]
    places, targets = np.array(knots).T
    inner = np.interp(times, places, targets)
    before, after = times < places[0], times > places[-1]
    return np.asarray(
        np.where(before, targets[0] + times - places[0], np.where(after, targets[-1] + times - places[-1], inner))
    )


def warped_by_motion(times: Floats, onto: Floats, source: Floats) -> Floats:
    """Where each instant of one take lies in another of the same words, from the motion of the mouth alone.

    For takes without phone times: dynamic time warping of the two motions, each about its own mean and of one spread
    (an expression is mostly an offset), then smoothed over 50 ms.

    Parameters
    ----------
    times : ndarray, shape (times,)
        Seconds.
    onto, source : ndarray, shapes (samples, dimensions) and (other samples, dimensions)
        Mouth motion at `_GRID` samples per second.

    Raises
    ------
    InputError
        If the two do not move alike even so.
    """
    from scipy.ndimage import gaussian_filter1d

    from mien.motion.warping import warping_path

    a, b = onto - onto.mean(axis=0), source - source.mean(axis=0)
    b = b * float(np.sqrt((a**2).mean() / max((b**2).mean(), 1e-12)))
    path = warping_path(a, b)
    met = np.bincount(path[:, 0], weights=path[:, 1]) / np.bincount(path[:, 0])
    smooth = np.maximum.accumulate(gaussian_filter1d(met, 0.05 * _GRID, mode="nearest"))
    there = b[np.clip(np.round(met), 0, len(b) - 1).astype(int)]
    alike = float((a * there).sum() / max(np.sqrt((a**2).sum() * (there**2).sum()), 1e-12))
    if alike < _ALIKE:
        raise InputError(
            f"expected the same sentence in both takes, but their mouths do not move alike (correlation {alike:.2f} "
            f"after warping, {_ALIKE:g} at least)"
        )
    return np.asarray(np.interp(times, np.arange(len(a)) / _GRID, smooth / _GRID))


def expressive_displacement(twins: Twins) -> Floats:
    """How far each marker lies from neutral speech once the words are taken out, shape (samples, markers, 3), mm.

    At `RATE`, over the speech of the neutral twin. Mouth markers lose the neutral frames, all others the neutral mean.

    Raises
    ------
    InputError
        If the takes do not share markers, do not say the same, or a marker was lost.
    """
    felt, plain = twins.expressive, twins.neutral
    if felt.markers.names != plain.markers.names or felt.layout != plain.layout:
        raise InputError(f"takes {felt.name!r} and {plain.name!r} have other markers: learn from one layout")
    try:
        times, elsewhere = _warp(plain, felt)
    except InputError as problem:
        raise InputError(f"takes {felt.name!r} and {plain.name!r}: {problem}") from problem
    neutral, moved = _at(plain, times), _at(felt, elsewhere)
    taken_out = np.broadcast_to(neutral.mean(axis=0), neutral.shape).copy()
    mouth = set(load_layout(plain.layout).groups["mouth"])
    words = [place for place, name in enumerate(plain.markers.names) if name in mouth]
    taken_out[:, words] = neutral[:, words]
    return np.asarray(moved - taken_out)


def _warp(plain: Take, felt: Take) -> tuple[Floats, Floats]:
    """Instants of the neutral take's speech, and where they lie in the other: by phones, or by motion without any."""
    spoken = [[phone for phone in take.phones if phone.label != PAUSE] for take in (plain, felt)]
    if all(spoken):
        times = np.arange(round(spoken[0][0].start * RATE), round(spoken[0][-1].end * RATE)) / RATE
        return times, warped_times(times, plain.phones, felt.phones)
    for take, phones in zip((plain, felt), spoken, strict=True):
        if not phones and len(take.words):
            raise InputError(f"take {take.name!r} has words but no phones: align it again")
    rows = []
    mouth = set(load_layout(plain.layout).groups["mouth"])
    columns = [place for place, name in enumerate(plain.markers.names) if name in mouth]
    for take in (plain, felt):
        frames = len(take.markers) / take.markers.rate.fps
        rows.append(_at(take, np.arange(round(frames * _GRID)) / _GRID)[:, columns].reshape(round(frames * _GRID), -1))
    times = np.arange(round(len(plain.markers) / plain.markers.rate.fps * RATE)) / RATE
    return times, warped_by_motion(times, *rows)


def _at(take: Take, times: Floats) -> Floats:
    """Marker positions at any instants, shape (times, markers, 3); held before the first and after the last frame."""
    positions = take.markers.positions
    lost = ~np.isfinite(positions).all(axis=(1, 2))
    if lost.any():
        raise InputError(
            f"take {take.name!r}: a marker was lost in frame {int(np.flatnonzero(lost)[0])}; fill gaps first"
        )
    frames = take.markers.rate.times(len(positions))
    flat = positions.reshape(len(positions), -1)
    columns = [np.interp(times, frames, column) for column in flat.T]
    return np.stack(columns, axis=1).reshape(len(times), -1, 3)
