"""The direction that goes with an utterance: which emotion, how strong, when."""

from __future__ import annotations

from dataclasses import dataclass

from mien.errors import InputError
from mien.script.curves import ParameterCurve

__all__ = ["EmotionSpan", "Score"]


@dataclass(frozen=True)
class EmotionSpan:
    """One emotion over a stretch of time.

    Attributes
    ----------
    name : str
        Name of an emotion, such as ``"happy"``.
    intensity : float
        0 (neutral) to 1 (full); SPEC A13.
    start, end : float or None
        Seconds; None means the start or end of the sound.
    """

    name: str
    intensity: float = 1.0
    start: float | None = None
    end: float | None = None

    def __post_init__(self) -> None:
        if not 0.0 <= self.intensity <= 1.0:
            raise InputError(
                f"an intensity runs from 0 to 1, not {self.intensity:g}"
                + (f": did you mean {self.intensity / 100:g}?" if 1 < self.intensity <= 100 else "")
            )

    @classmethod
    def parse(cls, text: str) -> EmotionSpan:
        """Read ``NAME`` or ``NAME:INTENSITY``.

        Examples
        --------
        >>> EmotionSpan.parse("sad:0.4")
        EmotionSpan(name='sad', intensity=0.4, start=None, end=None)
        """
        name, colon, number = text.partition(":")
        if not colon:
            return cls(name.strip().lower())
        try:
            return cls(name.strip().lower(), float(number))
        except ValueError as problem:
            raise InputError(f"an emotion is NAME or NAME:0..1, such as happy:0.6, not {text!r}") from problem


@dataclass(frozen=True)
class Score:
    """Everything that is asked of a performance besides the words themselves.

    Attributes
    ----------
    emotions : tuple of EmotionSpan
    curves : tuple of ParameterCurve
        Face parameters over time, as commands and scripts ask for them; laid over the rest of the motion.
    """

    emotions: tuple[EmotionSpan, ...] = ()
    curves: tuple[ParameterCurve, ...] = ()
