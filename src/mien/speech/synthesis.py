"""Text → sound with its words and phones in time."""

from __future__ import annotations

from mien.errors import AlignmentError, Note
from mien.speech.text import spoken_words
from mien.speech.utterance import Utterance
from mien.speech.voices import Speech, Voice, get_voice

__all__ = ["synthesise"]


def synthesise(text: str, voice: str | None = None, seed: int = 0) -> Utterance:
    """Speak a text.

    The times come from the engine, or from a forced alignment of its sound where that was measured to be better
    (`Voice.realign`, ``docs/tables/voices.md``).

    Parameters
    ----------
    text : str
        English as written: numbers and abbreviations are read out.
    voice : str or None
        A name of `mien.speech.voices.catalogue`; None takes the best one installed.
    seed : int
        Same text, voice and seed: same samples and times.

    Raises
    ------
    InputError
        If the text is empty or the voice cannot speak it, or there is no voice of this name.
    MissingPartError
        If the voice is not installed; the message tells how to install it.
    """
    spoken = spoken_words(text)
    speaker = get_voice(voice)
    speech = speaker.speak(spoken, seed)
    if speaker.realign or speech.phones is None:
        return _aligned(text, speaker, speech)
    return _as_spoken(text, speaker, speech).with_notes(*spoken.notes)


def _aligned(text: str, voice: Voice, speech: Speech) -> Utterance:
    try:
        from mien.speech.align import align
    except ModuleNotFoundError:
        return _as_spoken(text, voice, speech)
    try:
        return align(speech.audio, text)
    except AlignmentError as problem:
        if speech.phones is None:
            raise
        reason = Note("note", f"the times are the voice's own, since its sound could not be aligned: {problem}")
        return _as_spoken(text, voice, speech).with_notes(reason)


def _as_spoken(text: str, voice: Voice, speech: Speech) -> Utterance:
    if speech.phones is None or speech.words is None:
        raise AlignmentError(f"the voice {voice.name!r} gave no times; choose another voice")
    return Utterance(text, speech.audio, speech.words, speech.phones, voice.language, "voice")
