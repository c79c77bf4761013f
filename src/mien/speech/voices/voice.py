"""What a voice is: the one shape that every speech engine takes here."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from mien.core.audio import Audio
from mien.core.errors import MissingPartError, Note
from mien.core.timeline import Tier
from mien.speech.voices.sentences import Sentence, sentences_of
from mien.text.languages import Language
from mien.text.spoken_text import SpokenText

__all__ = ["Availability", "Break", "Speech", "Voice"]


@dataclass(frozen=True)
class Availability:
    """Whether a voice can speak on this machine.

    Attributes
    ----------
    installed : bool
    hint : str
        One line: where it was found, or the command that installs it.
    """

    installed: bool
    hint: str


@dataclass(frozen=True)
class Break:
    """A pause between two sentences: its middle in seconds, and how many words were said before it."""

    seconds: float
    words: int


@dataclass(frozen=True)
class Speech:
    """What a voice gives back.

    Attributes
    ----------
    audio : Audio
        Peak at -3 dBFS, a short silence at either end.
    phones : Tier or None
        ARPAbet without stress digits (the language's own signs where it is not English), pauses as ``SIL``, the whole
        sound without gaps; None if the engine has no times.
    words : Tier or None
        The words spoken, lower case.
    breaks : tuple of Break
        Where one sentence ends and the next begins, in order.
    """

    audio: Audio
    phones: Tier | None
    words: Tier | None
    breaks: tuple[Break, ...] = ()


class Voice(ABC):
    """One voice of one engine.

    Attributes
    ----------
    name : str
        As given to ``--voice``.
    language : str
        BCP 47 tag.
    own_language : Language or None
        How a language other than English is read and made; None for English.
    engine : str
        The program or model that makes the sound.
    licence, lineage : str
        One line each: the terms, and the data and weights it comes from.
    own_pronunciation : bool
        Whether the engine looks words up by itself, so that it may say other phones than `mien.text.pronunciation`.
    sounds : str
        ``"female"``, ``"male"`` or not known.
    realign : bool
        Whether a forced alignment of the sound gives better phone times than the engine's own. Measured by
        ``benchmarks/voices.py`` (``docs/tables/voices.md``).
    feeling : mapping of str to float
        Of what an emotion does to a voice (`mien.emotion.emotional_voice.FIGURES`) the share that this one carries; 1
        for what is not there.
    """

    name: str
    language: str
    engine: str
    licence: str
    lineage: str
    own_pronunciation: bool
    realign: bool
    own_language: Language | None = None
    sounds: str = ""
    feeling: Mapping[str, float] = MappingProxyType({})

    @abstractmethod
    def availability(self) -> Availability:
        """Whether the engine and its data are installed; quick, and never raises."""

    @abstractmethod
    def _speak(self, sentences: tuple[Sentence, ...], seed: int) -> Speech:
        """Say sentences; the voice is known to be installed."""

    def speak(self, spoken: SpokenText, seed: int = 0) -> Speech:
        """Say a text, sentence by sentence.

        The same text and seed give the same samples.

        Raises
        ------
        MissingPartError
            If the voice is not installed, or its engine does not work.
        """
        self.require()
        return self._speak(sentences_of(spoken), seed)

    def notes(self, spoken: SpokenText) -> tuple[Note, ...]:
        """What this voice cannot say as written, and says otherwise."""
        return ()

    def require(self) -> None:
        """Raise unless the voice is installed.

        Raises
        ------
        MissingPartError
            With the command that installs it.
        """
        found = self.availability()
        if not found.installed:
            raise MissingPartError(f"the voice {self.name!r} is not installed: {found.hint}")
