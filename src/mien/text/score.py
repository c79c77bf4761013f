"""The direction that goes with an utterance: which emotion, how strong, when."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.core.emotions import emotion_called
from mien.core.errors import InputError
from mien.text.effort_spans import EffortSpan
from mien.text.intensity import IntensityCurve, checked_intensity, parse_intensity
from mien.text.parameter_curves import ParameterCurve

__all__ = ["RAMP", "UNDIRECTED", "EmotionSpan", "Score"]

RAMP = 0.35
"""Seconds over which an emotion comes and goes where it starts or ends inside the line."""

_WRITTEN = re.compile(
    r"(?P<name>[^\[\]:@,]+)(\[\s*(?P<start>\d*\.?\d+)?\s*-\s*(?P<end>\d*\.?\d+)?\s*\])?(:(?P<intensity>.*))?"
)


@dataclass(frozen=True)
class EmotionSpan:
    """One emotion over a stretch of time.

    Attributes
    ----------
    name : str
        Name of an emotion, such as ``"happy"``; ``"joy"`` and other nouns are understood (`mien.core.emotions`).
    intensity : float or IntensityCurve
        0 (neutral) to 1 (full), held or changing over time; Deng et al. 2006.
    start, end : float or None
        Seconds; None means the start or end of the sound.

    Raises
    ------
    InputError
        If the intensity lies outside 0..1, or the stretch runs backwards.
    """

    name: str
    intensity: float | IntensityCurve = 1.0
    start: float | None = None
    end: float | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "name", emotion_called(self.name))
        if not isinstance(self.intensity, IntensityCurve):
            checked_intensity(self.intensity)
        if self.start is not None and self.end is not None and self.end < self.start:
            raise InputError(f"emotion {self.name!r} ends at {self.end:g} s, before it starts at {self.start:g} s")

    @classmethod
    def parse(cls, text: str) -> EmotionSpan:
        """Read ``NAME``, ``NAME:INTENSITY``, ``NAME[START-END]`` or ``NAME[START-END]:INTENSITY``.

        Start and end are seconds, either may be left out; the intensity is a number, points ``VALUE@SECOND`` parted
        by commas, or a CSV file (`mien.text.intensity`).

        Raises
        ------
        InputError
            If it is not written so.

        Examples
        --------
        >>> EmotionSpan.parse("sad:0.4")
        EmotionSpan(name='sad', intensity=0.4, start=None, end=None)
        >>> EmotionSpan.parse("angry[0.5-1.2]:0.8")
        EmotionSpan(name='angry', intensity=0.8, start=0.5, end=1.2)
        >>> EmotionSpan.parse("happy:0.2@0,0.9@1.5").intensity_at(np.array([0.75])).round(2).tolist()
        [0.55]
        """
        found = _WRITTEN.fullmatch(text.strip())
        if found is None:
            raise InputError(f"an emotion is NAME, NAME:0..1 or NAME[START-END]:0..1, such as happy:0.6, not {text!r}")
        start, end = (float(found[key]) if found[key] else None for key in ("start", "end"))
        intensity = parse_intensity(found["intensity"]) if found["intensity"] is not None else 1.0
        return cls(found["name"].strip().lower(), intensity, start, end)

    def intensity_at(self, seconds: NDArray[np.float64]) -> NDArray[np.float64]:
        """Intensities at instants, whether inside the stretch or not, shape (times,)."""
        if isinstance(self.intensity, IntensityCurve):
            return self.intensity.at(seconds)
        return np.full(len(seconds), float(self.intensity))

    def asked_at(self, seconds: NDArray[np.float64]) -> NDArray[np.float64]:
        """How much of the emotion is asked for at instants, shape (times,): 0 outside the stretch.

        It comes and goes with half a cosine over `RAMP` about each end that lies inside the line.
        """
        asked = self.intensity_at(seconds)
        if self.start is not None:
            asked = asked * _ease((seconds - self.start) / RAMP + 0.5)
        if self.end is not None:
            asked = asked * _ease((self.end - seconds) / RAMP + 0.5)
        return asked


def _ease(passed: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray((1 - np.cos(np.pi * np.clip(passed, 0.0, 1.0))) / 2)


@dataclass(frozen=True)
class Score:
    """Everything that is asked of a performance besides the words themselves.

    Attributes
    ----------
    emotions : tuple of EmotionSpan
    curves : tuple of ParameterCurve
        Face parameters over time, as commands and scripts ask for them; laid over the rest of the motion.
    efforts : tuple of EffortSpan
        How hard the words are articulated; a later one takes the place of earlier ones where it stands. Empty: as
        recorded, and as the emotions ask (docs/effort.md).
    """

    emotions: tuple[EmotionSpan, ...] = ()
    curves: tuple[ParameterCurve, ...] = ()
    efforts: tuple[EffortSpan, ...] = ()


UNDIRECTED = Score()
"""Nothing asked for."""
