"""Text → sound with its words and phones in time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Literal

from mien.core.audio import Audio
from mien.core.errors import AlignmentError, Note
from mien.core.progress import tell
from mien.core.timeline import Tier
from mien.core.utterance import PAUSE, Utterance
from mien.speech.align import align_words, tiers
from mien.speech.aligned_phone import AlignedPhone
from mien.speech.voices import Speech, Voice, get_voice
from mien.speech.voices.voice import Break
from mien.text.languages import Language, find_language, heard_as, in_english_phones, native_tier
from mien.text.languages.reading import read_in
from mien.text.normalisation import spoken_words
from mien.text.pronunciation import Pronunciation, pronounce, pronunciations
from mien.text.spoken_text import Spelled, SpokenText, with_spellings

__all__ = ["synthesise"]

_STRETCH = 15.0


def synthesise(
    text: str,
    voice: str | None = None,
    seed: int = 0,
    language: str | Path | None = None,
    spellings: Sequence[Spelled] = (),
) -> Utterance:
    """Speak a text.

    The times come from the engine, or from a forced alignment of its sound where that was measured to be better
    (`Voice.realign`, ``docs/tables/voices.md``).

    Parameters
    ----------
    text : str
        As written: numbers and abbreviations are read out.
    voice : str or None
        A name of `mien.speech.voices.catalogue`; None takes the best one that is installed.
    seed : int
        Same text, voice and seed: same samples and times.
    language : str, Path or None
        A tag such as ``"fi"`` or a phone map in a file; None takes the voice's, and English without one.
    spellings : sequence of (start, end, phones)
        Words to be pronounced as given; a voice that looks words up itself cannot, and a note says so.

    Returns
    -------
    Utterance
        Word ``i`` of its words tier is word ``i`` of ``spoken_words(text).words`` (for another language than English,
        of ``read_in(find_language(language), text).words``).

    Raises
    ------
    InputError
        If the text cannot be spoken, or there is no voice of this name.
    MissingPartError
        If the voice is not installed; the message tells how to install it.
    """
    speaker = get_voice(voice, find_language(language))
    own = speaker.own_language
    spoken = _spelled(spoken_words(text) if own is None else read_in(own, text), spellings, speaker)
    speech = speaker.speak(spoken, seed)
    if speaker.realign or speech.phones is None:
        utterance = _aligned(spoken, speaker, speech)
    else:
        utterance = _as_spoken(spoken, speaker, speech)
    return utterance.with_notes(*spoken.notes, *speaker.notes(spoken))


def _spelled(spoken: SpokenText, spellings: Sequence[Spelled], voice: Voice) -> SpokenText:
    if voice.own_pronunciation:
        message = "{!r} is not pronounced as asked by the voice " + repr(voice.name) + ": it looks words up itself"
        notes = [Note("note", message.format(spoken.written[start:end].strip())) for start, end, _ in spellings]
        return replace(spoken, notes=(*spoken.notes, *notes))
    return with_spellings(spoken, spellings, f"by the voice {voice.name!r}")


def _aligned(spoken: SpokenText, voice: Voice, speech: Speech) -> Utterance:
    if voice.own_language is not None:
        return _aligned_native(spoken, voice.own_language, speech)
    words = [word.text for word in spoken.words]
    choices: list[tuple[Pronunciation, ...]] = [
        pronunciations(word.text) if voice.own_pronunciation else (word.phones or pronounce(word.text),)
        for word in spoken.words
    ]
    try:
        phones = _align_by_sentence(speech, words, choices)
    except AlignmentError as problem:
        if speech.phones is None:
            raise
        reason = Note("note", f"the times are the voice's own, since its sound could not be aligned: {problem}")
        return _as_spoken(spoken, voice, speech).with_notes(reason)
    word_tier, phone_tier = tiers(phones, words, speech.audio.duration)
    return Utterance(spoken.written, speech.audio, word_tier, phone_tier, voice.language, "aligned")


def _aligned_native(spoken: SpokenText, language: Language, speech: Speech) -> Utterance:
    words = [word.text for word in spoken.words]
    heard = [heard_as(word.phones or (), language) for word in spoken.words]
    phones = _align_by_sentence(speech, words, [(choice,) for choice in heard])
    tier = native_tier(phones, [word.phones or () for word in spoken.words], language)
    return _in_language(spoken.written, speech.audio, tiers(phones, words, speech.audio.duration)[0], tier, language)


def _in_language(
    text: str,
    audio: Audio,
    words: Tier,
    native: Tier,
    language: Language,
    timing: Literal["aligned", "voice"] = "aligned",
) -> Utterance:
    phones, shapes = in_english_phones(native, language)
    return Utterance(text, audio, words, phones, language.tag, timing, native=native, shapes=shapes)


def _align_by_sentence(
    speech: Speech, words: Sequence[str], choices: Sequence[Sequence[Pronunciation]]
) -> list[AlignedPhone]:
    """Align stretches of whole sentences one by one: where they part is known, so nothing can slip across."""
    audio, found = speech.audio, list[AlignedPhone]()
    cuts = _cuts(speech, len(words))
    for number, (here, there) in enumerate(pairwise(cuts), start=1):
        first, last = round(here.seconds * audio.rate), round(there.seconds * audio.rate)
        stretch = Audio(audio.samples[first:last], audio.rate)
        inside = slice(here.words, there.words)
        for phone in align_words(stretch, words[inside], choices[inside]):
            word = phone.word + here.words if phone.word >= 0 else -1
            start, end = phone.start + first / audio.rate, phone.end + first / audio.rate
            if phone.label == PAUSE and found and found[-1].label == PAUSE:
                start = found.pop().start
            found.append(replace(phone, start=start, end=end, word=word))
        audio.rest()
        tell("finding the times", number, len(cuts) - 1)
    return found


def _cuts(speech: Speech, words: int) -> list[Break]:
    """The start, the breaks that part stretches of at most `_STRETCH` seconds where sentences allow it, the end."""
    end = Break(speech.audio.duration, words)
    cuts = [Break(0.0, 0)]
    for this, following in pairwise((*speech.breaks, end)):
        if following.seconds - cuts[-1].seconds > _STRETCH:
            cuts.append(this)
    return [*cuts, end]


def _as_spoken(spoken: SpokenText, voice: Voice, speech: Speech) -> Utterance:
    if speech.phones is None or speech.words is None:
        raise AlignmentError(f"the voice {voice.name!r} gave no times; choose another voice")
    if voice.own_language is not None:
        return _in_language(spoken.written, speech.audio, speech.words, speech.phones, voice.own_language, "voice")
    return Utterance(spoken.written, speech.audio, speech.words, speech.phones, voice.language, "voice")
