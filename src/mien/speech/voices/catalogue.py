"""Every voice there is, best first."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

from mien.core.errors import InputError, MissingPartError, unknown_name
from mien.core.plug_ins import plug_ins
from mien.speech.voices.espeak import Espeak, EspeakLanguage, espeak_languages
from mien.speech.voices.festival import festival_voices
from mien.speech.voices.kokoro import Kokoro
from mien.speech.voices.piper import Piper
from mien.speech.voices.voice import Voice
from mien.text.languages import Language

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
    brought = plug_ins("mien.voices", lambda thing: isinstance(thing, Voice), "a Voice").values()
    return (*kokoro, *festival_voices(), Espeak(), Piper(), *espeak_languages(), *(voice for _, voice in brought))


def _full_name(name: str, voices: Mapping[str, Voice], language: Language | None) -> str:
    """The name of a voice from itself, from the part of it that no other has, or from ``female`` and ``male``."""
    if name in voices:
        return name
    short = name.strip().lower()
    tag = None if language is None else language.tag
    fitting = [voice for voice in voices.values() if (voice.own_language and voice.own_language.tag) == tag]
    if short in ("female", "male"):
        kind = [voice for voice in fitting if voice.sounds == short]
        if not kind:
            raise InputError(
                f"no {short} voice speaks {language.name if language else 'English'}: mien voices lists all"
            )
        return next((voice.name for voice in kind if voice.availability().installed), kind[0].name)
    found = [known for known in voices if short in known.lower().split("-")]
    if len(found) == 1:
        return found[0]
    raise unknown_name("voice", name, voices)


def get_voice(name: str | None = None, language: Language | None = None) -> Voice:
    """The voice of a name, or the best one that is installed and speaks a language.

    Parameters
    ----------
    name : str or None
        In full, the part of it that no other has (``"heart"``), or ``"female"`` or ``"male"``.
    language : Language or None
        None: English, or whatever the named voice speaks.

    Raises
    ------
    InputError
        If there is no voice of this name, or it speaks another language.
    MissingPartError
        If it is not installed; the message holds the command that installs it.

    Examples
    --------
    >>> get_voice("kokoro-hart")
    Traceback (most recent call last):
        ...
    mien.core.errors.InputError: unknown voice 'kokoro-hart': did you mean 'kokoro-heart'? known: ...
    """
    voices = {voice.name: voice for voice in catalogue()}
    if language is not None and language.espeak:
        voices[f"espeak-{language.tag}"] = EspeakLanguage(language)  # also for a phone map of the user's own
    if name is not None:
        name = _full_name(name, voices, language)
        if language is not None and voices[name].own_language is None:
            raise InputError(f"the voice {name!r} speaks English, not {language.name}: leave --voice or --language out")
        if language is not None and voices[name].language != language.tag:
            raise InputError(f"the voice {name!r} speaks {voices[name].language!r}, not {language.name}")
        voices[name].require()
        return voices[name]
    tag = None if language is None else language.tag
    speaking = [voice for voice in voices.values() if (voice.own_language and voice.own_language.tag) == tag]
    for voice in speaking:
        if voice.availability().installed:
            return voice
    if not speaking:
        raise MissingPartError(f"no voice speaks {tag!r}")
    best = speaking[0] if language is not None else voices[DEFAULT_VOICE]
    raise MissingPartError(f"no voice is installed; for {best.name}, {best.availability().hint}")
