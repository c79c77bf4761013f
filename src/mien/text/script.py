"""`Script`: what was read from a text with tags or a document, before anything is spoken.

It knows places in the text, not times: those follow from the speech (`mien.pipeline.speak`).
"""

from __future__ import annotations

from dataclasses import dataclass, field

from mien.core.errors import Note
from mien.text.commands import Command
from mien.text.sync_points import Moment

__all__ = [
    "DirectedCommand", "DirectedCurve", "DirectedEffort", "DirectedEmotion", "Point", "Prosody", "Script", "Segment",
    "Spelling",
]  # fmt: skip


@dataclass(frozen=True)
class Spelling:
    """How a stretch of a segment's text is to be pronounced: ``text[start:end]`` as ARPAbet phones."""

    start: int
    end: int
    phones: tuple[str, ...]


@dataclass(frozen=True)
class Segment:
    """Text that is spoken in one go.

    Attributes
    ----------
    text : str
        May be without words: then it is only the silence before it.
    silence : float or None
        Milliseconds without sound before its first word, after the last word of what came before. None: as the voice
        parts sentences.
    start : Moment or None
        When it begins, if that is asked for; later where the speech before it lasts longer.
    voice : str or None
        A name, or several by preference with blanks between; ``...`` at their end: any voice, if none of them is there.
    spellings : tuple of Spelling
    """

    text: str
    silence: float | None = None
    start: Moment | None = None
    voice: str | None = None
    spellings: tuple[Spelling, ...] = ()


@dataclass(frozen=True)
class Point:
    """A named place in the text.

    Attributes
    ----------
    name : str
    segment, place : int
        Number of the segment, and of the character there before which it stands.
    after : bool
        Whether it means the end of the word before it rather than the start of the word that follows.
    """

    name: str
    segment: int
    place: int
    after: bool = False


@dataclass(frozen=True)
class Prosody:
    """How a stretch is spoken: ``rate`` (1: as usual, 2: twice as fast), ``pitch`` in semitones, ``volume`` in dB.

    None: nothing was asked, and the voice does what the emotion asks.
    """

    start: Moment
    end: Moment
    rate: float | None = None
    pitch: float | None = None
    volume: float | None = None


@dataclass(frozen=True)
class DirectedEmotion:
    """An emotion between two moments; None means the start or end of the sound.

    Attributes
    ----------
    name : str
    intensity : float
        Held, where there are no keys.
    start, end : Moment or None
    keys : tuple of (Moment, float)
        When it is how strong, if that changes (Deng et al. 2006).
    """

    name: str
    intensity: float
    start: Moment | None
    end: Moment | None
    keys: tuple[tuple[Moment, float], ...] = ()


@dataclass(frozen=True)
class DirectedEffort:
    """How hard somebody articulates between two moments (docs/effort.md).

    Attributes
    ----------
    level : float
        0 to 2, 1 as recorded; held, where there are no keys.
    start, end : Moment
    keys : tuple of (Moment, float)
        When it is how great, if that changes.
    """

    level: float
    start: Moment
    end: Moment
    keys: tuple[tuple[Moment, float], ...] = ()


@dataclass(frozen=True)
class DirectedCommand:
    """A command and when: ``until`` sets its parameter ``end`` (or ``duration``) to what lies between."""

    command: Command
    at: Moment
    until: Moment | None = None


@dataclass(frozen=True)
class DirectedCurve:
    """A curve of a face parameter; each key has a moment of its own."""

    parameter: str
    keys: tuple[tuple[Moment, float], ...]
    interpolation: str = "linear"
    mode: str = "add"
    fade: float = 0.0
    where: str = field(default="", compare=False)


@dataclass(frozen=True)
class Script:
    """Everything that a text or document asks for."""

    segments: tuple[Segment, ...] = ()
    points: tuple[Point, ...] = ()
    prosody: tuple[Prosody, ...] = ()
    emotions: tuple[DirectedEmotion, ...] = ()
    commands: tuple[DirectedCommand, ...] = ()
    curves: tuple[DirectedCurve, ...] = ()
    voice: str | None = None
    language: str | None = None
    notes: tuple[Note, ...] = ()
    efforts: tuple[DirectedEffort, ...] = ()

    @property
    def text(self) -> str:
        """What is spoken, all segments together."""
        return " ".join(segment.text.strip() for segment in self.segments if segment.text.strip())
