"""The hand-made mouth: key shapes by hand, cosine interpolation between them.

This is the last step of Algorithm 1 in Deng et al. 2006 ("a diphone never seen: cosine interpolation of the
key shapes"), used for everything. The key shapes and their timing rules are hand-made
(`assets/performance/visemes.toml`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import unknown_name
from mien.core.poses import pose_vector, read_table
from mien.core.timeline import FrameRate, Interval
from mien.core.tracks import MarkerTrack
from mien.core.utterance import PAUSE, Utterance

__all__ = ["HandMadeMouth", "MouthMotion", "Viseme", "cosine_interpolation"]

Floats = NDArray[np.float64]

# Timing of the rest shape in a pause: the lips settle within this time after speech and leave it this long before.
SETTLE, PREPARE = 0.18, 0.14
# A phone of this length (seconds) or longer reaches its key shape in full.
FULL_REACH = 0.11
_BLOCK = 4096  # frames
# A seal lasts at least this long, so that no closure falls between two frames at 25 frames per second.
SHORTEST_SEAL = 0.045


@dataclass(frozen=True)
class Viseme:
    """A key mouth shape and its timing rules; the fields are explained in ``visemes.toml``."""

    name: str
    shape: Floats
    hold: float = 0.0
    seal: float = 0.0
    yields: float = 0.0


@dataclass(frozen=True)
class MouthMotion:
    """What a mouth model makes of an utterance.

    Attributes
    ----------
    values : ndarray, shape (frames, channels)
        Weights of `mien.core.channels.ALL`; only the mouth moves.
    seal : ndarray, shape (frames,)
        0..1: how strictly the lips must stay shut (or the lip on the teeth) in this frame.
    markers : MarkerTrack or None
        The motion of the mouth's markers that the values follow, for models that move markers.
    """

    values: Floats
    seal: Floats
    markers: MarkerTrack | None = None


@dataclass(frozen=True)
class _Key:
    """A shape that is reached at ``start`` and kept until ``end``."""

    start: float
    end: float
    shape: Floats
    seal: float


class HandMadeMouth:
    """Mouth motion from phones by cosine interpolation between hand-made key shapes.

    Parameters
    ----------
    table : str
        Name of the table in ``assets/performance``.

    Examples
    --------
    >>> mouth = HandMadeMouth()
    >>> mouth.visemes_of("AY")
    ('open', 'spread')
    """

    def __init__(self, table: str = "visemes.toml") -> None:
        content = read_table(table)
        self.rest = Viseme("rest", pose_vector(content["rest"]["shape"], table))
        self.visemes = {
            name: Viseme(
                name,
                pose_vector(entry["shape"], f"{table}, viseme {name}"),
                hold=entry.get("hold", 0.0),
                seal=entry.get("seal", 0.0),
                yields=entry.get("yields", 0.0),
            )
            for name, entry in content["viseme"].items()
        }
        self._phones: dict[str, tuple[str, ...]] = {phone: tuple(v) for phone, v in content["phones"].items()}

    def visemes_of(self, phone: str) -> tuple[str, ...]:
        """Names of the key shapes that a phone passes through, in order."""
        return self._phones[phone]

    def shapes_of(self, utterance: Utterance) -> list[tuple[str, ...]]:
        """Names of the key shapes of each phone: the language's own where it has one, else the English phone's.

        Raises
        ------
        InputError
            If a language asks for a shape that is not in the table.
        """
        own = utterance.shapes or ((),) * len(utterance.phones)
        for name in (name for names in own for name in names):
            if name not in self.visemes:
                raise unknown_name("key shape asked for by the language", name, self.visemes)
        return [
            names or self._phones.get(phone.label, ("rest",))
            for phone, names in zip(utterance.phones, own, strict=True)
        ]

    def perform(self, utterance: Utterance, rate: FrameRate) -> MouthMotion:
        """Mouth channels for every frame that covers the sound."""
        motion = self.over(utterance, rate)(rate.times(rate.frames_covering(utterance.duration)))
        return MouthMotion(values=motion[:, :-1], seal=motion[:, -1])

    def over(self, utterance: Utterance, rate: FrameRate) -> Callable[[Floats], Floats]:
        """What gives mouth channels, and behind them the seal, at times; shape (times, channels + 1)."""
        keys = self._keys(utterance, rate)
        shapes = np.empty((len(keys), len(self.rest.shape) + 1))
        for row, key in zip(shapes, keys, strict=True):
            row[:-1], row[-1] = key.shape, key.seal
        holds = [(key.start, key.end) for key in keys]
        return lambda times: cosine_interpolation(times, holds, shapes)

    def seals(self, utterance: Utterance, rate: FrameRate) -> tuple[Floats, Floats]:
        """Where the lips must be shut (or on the teeth) and in which shape, for models that move the lips otherwise.

        Returns
        -------
        seal : ndarray, shape (frames,)
            0..1.
        shape : ndarray, shape (frames, channels)
            The key shape that seals, already weighed by ``seal``.
        """
        keys = self._keys(utterance, rate)
        weighed = [np.append(key.shape * key.seal, key.seal) for key in keys]
        motion = _interpolated(keys, utterance, rate, weighed)
        return motion[:, -1], motion[:, :-1]

    def share_of(self, utterance: Utterance, rate: FrameRate, chosen: Sequence[bool]) -> Floats:
        """How much of the mouth belongs to some of the phones: 1 at their key shapes, 0 at those of others.

        Parameters
        ----------
        utterance : Utterance
        rate : FrameRate
        chosen : sequence of bool
            For each phone.

        Returns
        -------
        ndarray, shape (frames,)
        """
        if not any(chosen):
            return np.zeros(rate.frames_covering(utterance.duration))
        keys = self._keys(utterance, rate)
        starts = [phone.start for phone in utterance.phones]
        places = np.searchsorted(starts, [(key.start + key.end) / 2 for key in keys], side="right") - 1
        weights = [np.array([float(place >= 0 and chosen[place])]) for place in places]
        return _interpolated(keys, utterance, rate, weights)[:, 0]

    def _keys(self, utterance: Utterance, rate: FrameRate) -> list[_Key]:
        shortest_seal = max(SHORTEST_SEAL, 1.01 / rate.fps)
        keys: list[_Key] = []
        for phone, names in zip(utterance.phones, self.shapes_of(utterance), strict=True):
            if phone.label == PAUSE:
                keys += self._pause_keys(phone, utterance.duration)
            else:
                keys += self._phone_keys(phone, names, shortest_seal)
        return _in_order(keys or [_Key(0.0, utterance.duration, self.rest.shape, 0.0)])

    def _pause_keys(self, pause: Interval, duration: float) -> list[_Key]:
        settled = pause.start + SETTLE if pause.start > 0 else 0.0
        leaving = pause.end - PREPARE if pause.end < duration else duration
        if leaving <= settled:  # a short pause: the mouth only passes through half-way to rest
            return []
        return [_Key(settled, leaving, self.rest.shape, 0.0)]

    def _phone_keys(self, phone: Interval, names: tuple[str, ...], shortest_seal: float) -> list[_Key]:
        part = phone.duration / len(names)
        reach = min(1.0, phone.duration / FULL_REACH)
        keys = []
        for place, name in enumerate(names):
            viseme = self.visemes[name]
            middle = phone.start + (place + 0.5) * part
            half = viseme.hold * part / 2
            if viseme.seal:
                half = max(half, shortest_seal / 2)
            shape = viseme.shape * (1 - viseme.yields * (1 - reach))
            keys.append(_Key(middle - half, middle + half, shape, viseme.seal))
        return keys


def _interpolated(keys: list[_Key], utterance: Utterance, rate: FrameRate, shapes: list[Floats]) -> Floats:
    times = rate.times(rate.frames_covering(utterance.duration))
    return cosine_interpolation(times, [(key.start, key.end) for key in keys], np.array(shapes))


def _in_order(keys: list[_Key]) -> list[_Key]:
    """Where two holds overlap, the sealed one keeps its time and the other gives way; else they meet half-way."""
    ordered = keys[:1]
    for key in keys[1:]:
        before = ordered[-1]
        if before.end > key.start:
            if before.seal > key.seal:
                border = before.end
            elif key.seal > before.seal:
                border = key.start
            else:
                border = (before.end + key.start) / 2
            ordered[-1] = _Key(min(before.start, border), border, before.shape, before.seal)
            key = _Key(border, max(key.end, border), key.shape, key.seal)
        ordered.append(key)
    return ordered


def cosine_interpolation(times: Floats, holds: list[tuple[float, float]], shapes: Floats) -> Floats:
    """Stand at ``shapes[k]`` during ``holds[k]`` and pass from one to the next on a half cosine.

    Parameters
    ----------
    times : ndarray, shape (frames,)
        Seconds.
    holds : list of (start, end)
        Seconds, in order, not overlapping; ``start == end`` means the shape is only touched.
    shapes : ndarray, shape (keys, channels)

    Returns
    -------
    ndarray, shape (frames, channels)

    Notes
    -----
    Between the end ``a`` of one hold and the start ``b`` of the next the later shape weighs
    ``(1 - cos(pi (t - a) / (b - a))) / 2``.

    Examples
    --------
    >>> cosine_interpolation(np.array([0.0, 0.5, 1.0]), [(0, 0), (1, 1)], np.array([[0.0], [2.0]])).round(9).tolist()
    [[0.0], [1.0], [2.0]]
    """
    found, (starts, ends) = np.empty((len(times), shapes.shape[1])), np.array(holds).T
    for first in range(0, len(times), _BLOCK):  # a long line is not held many times over
        here = slice(first, first + _BLOCK)
        after = np.searchsorted(ends, times[here], side="left")  # first key whose hold has not ended
        before = np.clip(after - 1, 0, len(holds) - 1)
        after = np.clip(after, 0, len(holds) - 1)
        span = starts[after] - ends[before]
        passed = np.where(span > 0, (times[here] - ends[before]) / np.where(span > 0, span, 1.0), 1.0)
        weight = (1 - np.cos(np.pi * np.clip(passed, 0.0, 1.0))) / 2
        found[here] = shapes[before] * (1 - weight[:, None]) + shapes[after] * weight[:, None]
    return found
