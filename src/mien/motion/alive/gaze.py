"""Glances: eyes on the one spoken to and away from them, saccades of the sizes, ways and lengths that people's have.

The figures stand in ``assets/performance/gaze.toml`` (after Lee, Badler & Badler 2002). Not learned by us: drawn from
their published distributions. A command such as ``LookAt`` sets the eyes and takes the place of glances. What is felt
changes how long eyes stay, how far they go and where (`mien.motion.alive.manner`).
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core import channels
from mien.core.poses import read_table
from mien.core.utterance import PAUSE, Utterance
from mien.motion.alive.manner import Manner
from mien.text.score import UNDIRECTED, Score

__all__ = ["HandMadeGaze", "Saccade"]

Floats = NDArray[np.float64]
_LEAST_HOLD = 0.2  # seconds between two saccades (their refractory time)


@dataclass(frozen=True)
class Saccade:
    """A jump of the eyes.

    Attributes
    ----------
    start : float
        Seconds.
    side, height : float
        Where it lands, degrees to the speaker's left and up.
    seconds : float
        How long it takes.
    """

    start: float
    side: float
    height: float
    seconds: float


class HandMadeGaze:
    """Glances for the length of an utterance.

    Parameters
    ----------
    table : str
        A file of ``assets/performance``.
    """

    def __init__(self, table: str = "gaze.toml") -> None:
        self._table: dict[str, Any] = read_table(table)
        ways = {float(angle): float(share) for angle, share in self._table["direction"].items()}
        self._angles, self._shares = np.array(list(ways)), np.array(list(ways.values())) / sum(ways.values())

    def perform(
        self, utterance: Utterance, times: Floats, random: np.random.Generator, score: Score = UNDIRECTED
    ) -> Floats:
        """The eyeLook channels at the times, shape (times, channels)."""
        values = np.zeros((len(times), len(channels.ALL)))
        self.look(values, utterance, times, random, score)
        return values

    def look(
        self,
        values: Floats,
        utterance: Utterance,
        times: Floats,
        random: np.random.Generator,
        score: Score = UNDIRECTED,
    ) -> None:
        """Set the eyeLook channels of some motion at the times, shape (times, channels)."""
        saccades = self.saccades(utterance, float(times[-1]) + 1.0 if len(times) else 1.0, random, score)
        side, height = self.directions(saccades, times)
        degrees = self._table["degrees"]
        for name, amount, full in (
            ("eyeLookOutLeft", side, degrees["out"]),
            ("eyeLookInRight", side, degrees["in"]),
            ("eyeLookInLeft", -side, degrees["in"]),
            ("eyeLookOutRight", -side, degrees["out"]),
            ("eyeLookUpLeft", height, degrees["up"]),
            ("eyeLookUpRight", height, degrees["up"]),
            ("eyeLookDownLeft", -height, degrees["down"]),
            ("eyeLookDownRight", -height, degrees["down"]),
        ):
            values[:, channels.ALL.index(name)] = np.clip(amount / full, 0.0, 1.0)

    def saccades(
        self, utterance: Utterance, end: float, random: np.random.Generator, score: Score = UNDIRECTED
    ) -> list[Saccade]:
        """All saccades up to ``end`` seconds, in order; ``score``: what is felt when."""
        found: list[Saccade] = []
        manner, now = Manner(score, end), 0.0
        while now < end:
            state = self._table["talking" if _speaks(utterance, now) else "listening"]
            until = now + _held(state["on"], random, manner.at("on", now))
            while now < until:  # small moves about the one spoken to
                rest = random.exponential(self._table["fixation"]["hold"])
                now += max(_LEAST_HOLD, rest * manner.at("hold", now))
                landing = self._small_move(manner, now, random)
                if now < until:
                    found.append(self._saccade(found, now, *landing))
            now = until
            size, angle = self._size(random), float(random.choice(self._angles, p=self._shares))
            size *= manner.at("spread", now)
            across, up = size * np.cos(np.radians(angle)), size * np.sin(np.radians(angle))
            up -= manner.at("down", now) + manner.at("aside", now)
            found.append(self._saccade(found, now, float(across), float(up)))
            now += _held(state["away"], random, manner.at("away", now))
            found.append(self._saccade(found, now, *self._small_move(manner, now, random)))
        return found

    def _small_move(self, manner: Manner, now: float, random: np.random.Generator) -> tuple[float, float]:
        """Where a small move about the one spoken to lands."""
        across, up = random.standard_normal(2) * self._table["fixation"]["spread"] * manner.at("spread", now)
        return float(across), float(up - manner.at("down", now))

    def directions(self, saccades: list[Saccade], times: Floats) -> tuple[Floats, Floats]:
        """Degrees to the speaker's left, and up, at the times."""
        start = np.array([-1.0, *(s.start for s in saccades)])
        lands = np.array([(0.0, 0.0), *((s.side, s.height) for s in saccades)])
        lasts = np.array([1.0, *(s.seconds for s in saccades)])
        current = np.searchsorted(start, times, side="right") - 1
        passed = np.clip((times - start[current]) / lasts[current], 0, 1)
        passed = passed * passed * (3 - 2 * passed)  # speeds up and slows down
        before = lands[np.maximum(current - 1, 0)]
        at = before + (lands[current] - before) * passed[:, None]
        return at[:, 0], at[:, 1]

    def _size(self, random: np.random.Generator) -> float:
        drawn = -self._table["size"]["scale"] * np.log(max(15.0 * random.random(), 1e-9) / 15.7)
        return float(min(drawn, self._table["size"]["most"]) * self._table["portrait"]["size"])

    def _saccade(self, found: list[Saccade], start: float, side: float, height: float) -> Saccade:
        last = found[-1] if found else Saccade(-1.0, 0.0, 0.0, 0.0)
        size = float(np.hypot(side - last.side, height - last.height))
        seconds = self._table["duration"]["intercept"] + self._table["duration"]["slope"] * size
        return Saccade(max(start, last.start + last.seconds), side, height, seconds)


def _held(mean_and_spread: list[float], random: np.random.Generator, longer: float) -> float:
    """A stay of this mean and spread, so many times as long: gamma, since it is above 0 and skewed."""
    mean, spread = mean_and_spread
    return max(_LEAST_HOLD, float(random.gamma((mean / spread) ** 2, spread**2 / mean)) * longer)


def _speaks(utterance: Utterance, moment: float) -> bool:
    """Whether speech is on at a moment, pauses shorter than a second included."""
    phones = utterance.phones.intervals
    first = bisect_right(phones, moment - 0.5, key=lambda phone: phone.end)
    after = bisect_right(phones, moment + 0.5, key=lambda phone: phone.start)
    return any(phone.label != PAUSE for phone in phones[first:after])
