"""By how much the motion of a recording is later than its sound.

`lag_from_sound` correlates the opening of the lips with the loudness of the sound; `lag_from_phones` asks at which
shift the phones (each with an opening of its own, learned from the same takes) say most about the opening. Both
read the sound between frames, so the answer is finer than a frame. One take of a few seconds gives a poor answer; give
all takes of a session that share one clock.

Lips run ahead of the phone they are for, so `lag_from_phones` comes out earlier than the true lag by about that
anticipation; the loudness, which only shows when the mouth lets sound out, does not.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import erf

from mien.capture.cleaning.normalise import columns
from mien.core.audio import Audio
from mien.core.errors import InputError
from mien.core.timeline import Tier
from mien.core.tracks import MarkerTrack

__all__ = ["MAX_LAG", "Lag", "lag_from_phones", "lag_from_sound", "lip_opening"]

MAX_LAG = 0.2
_STEP = 0.005
_LOUDNESS_WINDOW = 0.02  # s, standard deviation
_PHONE_EDGE = 0.04  # s, standard deviation of the edges of a phone
_SURROGATES = 20


@dataclass(frozen=True)
class Lag:
    """The lag of motion behind sound.

    Attributes
    ----------
    seconds : float
        Above 0: the motion is late; shift it earlier by this much. NaN where the fit is best at the end of what was
        searched: the true lag may lie beyond, or there is none; then the confidence is 0.
    fit : float
        Correlation at the best shift (`lag_from_sound`), or share of variance said by the phones (`lag_from_phones`).
    error : float
        Standard error by leaving out one take at a time, s; NaN for a single take.
    confidence : float
        Share of mismatched pairings (the motion moved round by half a second and more) that fit worse at their best
        shift, 0..1. Below about 0.95 the answer may be chance.
    """

    seconds: float
    fit: float
    error: float
    confidence: float


@dataclass(frozen=True, eq=False)
class _Curves:
    """For every take the sums that make the fit, by shift, and a way to fit them together."""

    shifts: NDArray[np.float64]
    fit: Callable[[NDArray[np.intp], int], NDArray[np.float64]]  # (takes, surrogate) -> fit by shift
    takes: int


def lip_opening(track: MarkerTrack, upper_lip: str, lower_lip: str) -> NDArray[np.float64]:
    """Distance between two lip markers, mm, shape (frames,); NaN where one is missing."""
    upper, lower = columns(track, (upper_lip, lower_lip))
    opening: NDArray[np.float64] = np.linalg.norm(track.positions[:, upper] - track.positions[:, lower], axis=1)
    return opening


def lag_from_sound(
    tracks: Sequence[MarkerTrack], sounds: Sequence[Audio], lips: tuple[str, str], most: float = MAX_LAG
) -> Lag:
    """Estimate the lag from the loudness of the sound.

    Parameters
    ----------
    tracks : sequence of MarkerTrack
        One or more takes of one session; frame 0 at the start of the sound.
    sounds : sequence of Audio
    lips : (str, str)
        Markers of the upper and the lower lip.
    most : float
        Largest lag that is looked for, s.

    Raises
    ------
    InputError
        If there is nothing to correlate: no takes, still lips, or a silent sound.
    """
    _check_pairs(len(tracks), len(sounds), "sounds")
    shifts = _shifts(most)
    openings = [lip_opening(track, *lips) for track in tracks]
    loud = []
    for track, sound in zip(tracks, sounds, strict=True):
        times = track.rate.times(len(track))
        loudness = _loudness(sound)
        axis = (np.arange(len(loudness)) + 0.5) / 1000.0
        loud.append(np.stack([np.interp(times - shift, axis, loudness) for shift in shifts]))
    rows = np.stack(
        [
            np.stack([_correlations(_rolled(o, s, t), e) for s in range(_SURROGATES + 1)])
            for o, e, t in zip(openings, loud, tracks, strict=True)
        ]
    )
    usable = np.flatnonzero(np.isfinite(rows[:, 0]).all(axis=1))
    if not usable.size:
        raise InputError("no lag can be estimated: the lips do not move or the sound is silent in every take")
    rows = np.nan_to_num(rows[usable])
    return _best(_Curves(shifts, lambda takes, surrogate: rows[takes, surrogate].mean(axis=0), len(rows)))


def lag_from_phones(
    tracks: Sequence[MarkerTrack], phones: Sequence[Tier], lips: tuple[str, str], most: float = MAX_LAG
) -> Lag:
    """Estimate the lag from the times of the phones; for a dozen takes or more.

    Parameters
    ----------
    tracks, lips, most
        As for `lag_from_sound`.
    phones : sequence of Tier

    Raises
    ------
    InputError
        If there are no takes, or the lips do not move.
    """
    _check_pairs(len(tracks), len(phones), "phone tiers")
    shifts = _shifts(most)
    labels = sorted({phone.label for tier in phones for phone in tier})
    if not labels:
        raise InputError("no lag can be estimated: the takes have no phones")
    openings = [lip_opening(track, *lips) for track in tracks]
    sums = np.stack(
        [
            np.stack([_normal_sums(track, tier, labels, shifts, _rolled(o, s, track)) for s in range(_SURROGATES + 1)])
            for o, tier, track in zip(openings, phones, tracks, strict=True)
        ]
    )
    if float(_explained(sums[:, 0].sum(axis=0)).max(initial=0.0)) <= 0:
        raise InputError("no lag can be estimated: the lips do not move in any take")
    return _best(_Curves(shifts, lambda takes, surrogate: _explained(sums[takes, surrogate].sum(axis=0)), len(sums)))


def _check_pairs(tracks: int, others: int, what: str) -> None:
    if not tracks or tracks != others:
        raise InputError(f"lag: expected as many {what} as tracks and at least one, got {others} for {tracks}")


def _shifts(most: float) -> NDArray[np.float64]:
    if not most >= 2 * _STEP:
        raise InputError(f"lag: the largest lag looked for is at least {2 * _STEP} s, not {most}")
    count = round(most / _STEP)
    return np.asarray(np.arange(-count, count + 1) * _STEP, dtype=np.float64)


def _loudness(sound: Audio) -> NDArray[np.float64]:
    """Square root of the RMS in a sliding Gaussian window, 1000 values a second, each for the middle of its ms."""
    from scipy.ndimage import gaussian_filter1d

    edges = np.arange(int(sound.duration * 1000) + 1) * sound.rate // 1000
    energy = np.concatenate([[0.0], np.cumsum(sound.samples.astype(np.float64) ** 2)])
    power = np.diff(energy[edges]) / np.maximum(np.diff(edges), 1)
    smooth = gaussian_filter1d(np.maximum(power, 0.0), _LOUDNESS_WINDOW * 1000, mode="constant")
    loudness: NDArray[np.float64] = np.maximum(smooth, 0.0) ** 0.25
    return loudness


def _rolled(opening: NDArray[np.float64], surrogate: int, track: MarkerTrack) -> NDArray[np.float64]:
    """The opening moved round: surrogate 0 is the truth, the others lie between half a second and as much from it."""
    if surrogate == 0:
        return opening
    margin = min(round(0.5 * track.rate.fps), len(opening) // 4)
    return np.roll(opening, margin + (len(opening) - 2 * margin) * surrogate // (_SURROGATES + 1))


def _correlations(opening: NDArray[np.float64], loud: NDArray[np.float64]) -> NDArray[np.float64]:
    """Correlation of the opening with the loudness at every shift (shifts, frames); NaN where one of them is flat."""
    seen = np.isfinite(opening)
    x = opening[seen] - opening[seen].mean() if seen.any() else opening[seen]
    y = loud[:, seen] - loud[:, seen].mean(axis=1, keepdims=True) if seen.any() else loud[:, seen]
    size = np.linalg.norm(x) * np.linalg.norm(y, axis=1)
    result = np.full(len(loud), np.nan)
    np.divide(y @ x, size, out=result, where=size > 1e-12)
    return result


def _normal_sums(
    track: MarkerTrack,
    tier: Tier,
    labels: list[str],
    shifts: NDArray[np.float64],
    opening: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Per shift the cross products of phones, one and opening, shape (shifts, labels + 2, labels + 2)."""
    seen = np.isfinite(opening)
    times = track.rate.times(len(track))[seen]
    sums = []
    for shift in shifts:
        design = np.zeros((len(times), len(labels) + 2))
        for phone in tier:
            rise = erf((times - shift - phone.start) / (_PHONE_EDGE * np.sqrt(2)))
            fall = erf((times - shift - phone.end) / (_PHONE_EDGE * np.sqrt(2)))
            design[:, labels.index(phone.label)] += 0.5 * (rise - fall)
        design[:, -2] = 1.0
        design[:, -1] = opening[seen]
        sums.append(design.T @ design)
    return np.stack(sums)


def _explained(sums: NDArray[np.float64]) -> NDArray[np.float64]:
    """Share of the opening's variance that the phones explain, per shift (ridge, so that rare phones do no harm)."""
    result = np.zeros(len(sums))
    for index, table in enumerate(sums):
        inner, cross, total = table[:-1, :-1], table[:-1, -1], table[-1, -1]
        variance = total - cross[-1] ** 2 / max(inner[-1, -1], 1.0)
        penalty = np.eye(len(inner))
        penalty[-1, -1] = 1e-9
        weights = np.linalg.solve(inner + penalty, cross)
        left = total - 2 * weights @ cross + weights @ inner @ weights
        result[index] = 1.0 - left / variance if variance > 1e-12 else 0.0
    return result


def _best(curves: _Curves) -> Lag:
    everyone = np.arange(curves.takes)
    truth = curves.fit(everyone, 0)
    seconds, fit = _peak(curves.shifts, truth)
    error = float("nan")
    if np.isnan(seconds):
        return Lag(seconds, fit, error, 0.0)
    if curves.takes > 1:
        left_out = np.array([_peak(curves.shifts, curves.fit(np.delete(everyone, i), 0))[0] for i in everyone])
        error = float(np.sqrt((curves.takes - 1) / curves.takes * ((left_out - left_out.mean()) ** 2).sum()))
    chance = [float(curves.fit(everyone, s).max()) for s in range(1, _SURROGATES + 1)]
    return Lag(seconds, fit, error, float(np.mean([c < fit for c in chance])))


def _peak(shifts: NDArray[np.float64], fit: NDArray[np.float64]) -> tuple[float, float]:
    """Place and height of the highest point, refined by a parabola through its neighbours; NaN at either end."""
    top = int(np.argmax(fit))
    if top in (0, len(fit) - 1):
        return float("nan"), float(fit[top])
    before, here, after = fit[top - 1 : top + 2]
    bend = before - 2 * here + after
    part = 0.5 * (before - after) / bend if bend < 0 else 0.0
    return float(shifts[top] + part * (shifts[1] - shifts[0])), float(here - 0.25 * (before - after) * part)
