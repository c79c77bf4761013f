"""Every voice there is, best first."""

from __future__ import annotations

from functools import cache

from mien.errors import MissingPartError, unknown_name
from mien.speech.voices.espeak import Espeak
from mien.speech.voices.festival import festival_voices
from mien.speech.voices.kokoro import Kokoro
from mien.speech.voices.piper import Piper
from mien.speech.voices.voice import Voice

__all__ = ["DEFAULT_VOICE", "catalogue", "get_voice"]

DEFAULT_VOICE = "kokoro-heart"


@cache
def catalogue() -> tuple[Voice, ...]:
    """All voices, installed or not, in the order in which they are preferred (``docs/tables/voices.md``).

    Examples
    --------
    >>> catalogue()[0].name
    'kokoro-heart'
    """
    kokoro = tuple(Kokoro(speaker) for speaker in ("heart", "bella", "michael", "fenrir"))
    return (*kokoro, *festival_voices(), Espeak(), Piper())


def get_voice(name: str | None = None) -> Voice:
    """The voice of a name, or the best one that is installed.

    Raises
    ------
    InputError
        If there is no voice of this name.
    MissingPartError
        If it is not installed; the message holds the command that installs it.

    Examples
    --------
    >>> get_voice("kokoro-hart")
    Traceback (most recent call last):
        ...
    mien.errors.InputError: unknown voice 'kokoro-hart': did you mean 'kokoro-heart'? known: ...
    """
    voices = {voice.name: voice for voice in catalogue()}
    if name is not None:
        if name not in voices:
            raise unknown_name("voice", name, voices)
        voices[name].require()
        return voices[name]
    for voice in voices.values():
        if voice.availability().installed:
            return voice
    hint = voices[DEFAULT_VOICE].availability().hint
    raise MissingPartError(f"no voice is installed; for the default one, {DEFAULT_VOICE}, {hint}")
