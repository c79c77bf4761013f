"""What is said, and when: the bridge from speech to motion."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

from mien.audio import Audio
from mien.errors import Note
from mien.timeline import Tier

__all__ = ["PAUSE", "Utterance"]

PAUSE = "SIL"
"""Label of a pause in the phone tier."""


@dataclass(frozen=True)
class Utterance:
    """A stretch of speech with its words and phones in time.

    Attributes
    ----------
    text : str
        What was given or recognised, as written.
    audio : Audio
        The sound. Times of both tiers are seconds from its start.
    words : Tier
        Spoken words, lower case, without gaps filled.
    phones : Tier
        ARPAbet phones without stress digits (39 of them), pauses as `PAUSE`; covers the whole sound without gaps.
    language : str
        BCP 47 tag, such as ``"en-US"``.
    timing : {"aligned", "recognised", "voice", "none"}
        Where the times come from: forced alignment with a text, recognition without one (approximate), the voice
        that spoke it, or nothing (no speech was found).
    notes : tuple of Note
        What a person should know, for instance a stretch where text and sound do not fit.
    """

    text: str
    audio: Audio
    words: Tier
    phones: Tier
    language: str
    timing: Literal["aligned", "recognised", "voice", "none"]
    notes: tuple[Note, ...] = ()

    @property
    def duration(self) -> float:
        """Seconds of sound."""
        return self.audio.duration

    def with_notes(self, *notes: Note) -> Utterance:
        """The same utterance with further notes."""
        return replace(self, notes=self.notes + notes)
