"""What is said, and when: the bridge from speech to motion."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

from mien.core.audio import Audio
from mien.core.errors import InputError, Note
from mien.core.timeline import Tier

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
    timing : {"aligned", "recognised", "voice", "given", "none"}
        Where the times come from: forced alignment with a text, recognition without one (approximate), the voice
        that spoke it, a person (a corrected TextGrid), or nothing (no speech was found).
    notes : tuple of Note
        What a person should know, for instance a stretch where text and sound do not fit.
    native : Tier or None
        The phones as the language itself has them (IPA: ``"yː"``), for a language other than English; `phones` then are
        the English ones made most alike, and may be more or fewer.
    shapes : tuple of tuple of str
        For each of `phones` the names of key shapes (``assets/performance/visemes.toml``) that it takes instead of the
        English phone's, where English has none like it; empty if no phone has any.
    sung : bool
        Whether it is a song: vowels are held, and the jaw follows the voice.

    Raises
    ------
    InputError
        If there are shapes, but not one entry for each phone.
    """

    text: str
    audio: Audio
    words: Tier
    phones: Tier
    language: str
    timing: Literal["aligned", "recognised", "voice", "given", "none"]
    notes: tuple[Note, ...] = ()
    native: Tier | None = None
    shapes: tuple[tuple[str, ...], ...] = ()
    sung: bool = False

    def __post_init__(self) -> None:
        if self.shapes and len(self.shapes) != len(self.phones):
            raise InputError(f"expected key shapes for {len(self.phones)} phones, got them for {len(self.shapes)}")

    @property
    def spelled_phones(self) -> Tier:
        """The phones in the language's own signs: what a person reads, in a TextGrid or on a contact sheet."""
        return self.phones if self.native is None else self.native

    @property
    def duration(self) -> float:
        """Seconds of sound."""
        return self.audio.duration

    def with_notes(self, *notes: Note) -> Utterance:
        """The same utterance with further notes."""
        return replace(self, notes=self.notes + notes)
