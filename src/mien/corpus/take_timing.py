"""When each word and phone of a take is said: from its TextGrid, or by forced alignment."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mien.core.audio import Audio
from mien.core.errors import InputError, Note
from mien.core.timeline import Interval, Tier
from mien.core.utterance import PAUSE
from mien.corpus.recipes import Recipe
from mien.corpus.transcripts import Transcript
from mien.speech.align import align_words, choices_of, tiers
from mien.speech.transcript_doubts import LOWEST_PHONE_SCORE, LOWEST_RUN_SCORE, LOWEST_RUN_SCORE_THROUGH_A_MAP, doubts
from mien.text.languages import find_language, in_english_phones, native_tier
from mien.text.languages.reading import read_in
from mien.text.normalisation import spoken_words
from mien.text.pronunciation import Pronunciation, pronunciations

__all__ = ["Timed", "timed", "without_holes"]

_SHORTEST_SOUND = 0.1


@dataclass(frozen=True, eq=False)
class Timed:
    """Words and phones of a take.

    Attributes
    ----------
    words, phones : Tier
        Phones of other languages as the English ones made most alike.
    confidence : float or None
        Mean score of the phones (about -0.8 where text and sound fit, below -2.6 where they do not; see
        `mien.speech.transcript_doubts`). None where nothing was aligned.
    notes : tuple of Note
    """

    words: Tier
    phones: Tier
    confidence: float | None
    notes: tuple[Note, ...]


def timed(audio: Audio, transcript: Transcript, recipe: Recipe, source: str) -> Timed:
    """Place the words of a transcript in the sound.

    Raises
    ------
    InputError
        If the language cannot be aligned, the sound is silent or too short, or no alignment was found.
    """
    if transcript.phones is not None and transcript.words is not None:
        return Timed(*timed_by_grid(transcript, audio.duration, source), None, ())
    if audio.duration < _SHORTEST_SOUND or audio.is_silent():
        raise InputError(f"{source}: its {audio.duration:.2f} s of sound are silent: is it the right file or channel?")
    try:
        found = _aligned(audio, transcript.text, recipe)
    except InputError as problem:
        raise InputError(f"{source}: {problem}") from problem
    return replace(found, notes=tuple(Note(note.kind, f"{source}: {note.message}") for note in found.notes))


def timed_by_grid(transcript: Transcript, duration: float, source: str) -> tuple[Tier, Tier]:
    """Words and phones as a TextGrid has them, over the whole of a sound.

    Raises
    ------
    InputError
        If the TextGrid has no phones, or goes on after the sound has ended.
    """
    if transcript.phones is None or transcript.words is None:
        raise InputError(f"{source}: its TextGrid has no tier of phones")
    end = max(i.end for i in (*transcript.words, *transcript.phones))
    if end > duration + 0.1:
        raise InputError(f"{source}: its TextGrid ends at {end:.2f} s, its sound at {duration:.2f} s")
    return transcript.words, without_holes(transcript.phones, duration)


def _aligned(audio: Audio, text: str, recipe: Recipe) -> Timed:
    """By the acoustic model of English, for another language through its phone map."""
    language = find_language(recipe.language)
    spoken = spoken_words(text) if language is None else read_in(language, text)
    words = [word.text for word in spoken.words]
    if language is None:
        choices = [_ways_to_say(word, recipe) for word in words]
    else:
        choices = [choices_of(word, language) for word in spoken.words]
    phones = align_words(audio, words, choices)
    word_tier, phone_tier = tiers(phones, words, audio.duration)
    scores = [max(phone.score, LOWEST_PHONE_SCORE) for phone in phones if phone.word >= 0]
    lowest = LOWEST_RUN_SCORE if language is None else LOWEST_RUN_SCORE_THROUGH_A_MAP
    notes = spoken.notes + doubts(audio, spoken, phones, lowest)
    if language is not None:
        native = native_tier(phones, [word.phones or () for word in spoken.words], language)
        phone_tier, _ = in_english_phones(native, language)
        if recipe.pronunciations:
            notes += (Note("note", f"pronunciations of the recipe are for English, not {language.name}: left out"),)
    return Timed(word_tier, phone_tier, float(np.mean(scores)), notes)


def _ways_to_say(word: str, recipe: Recipe) -> tuple[Pronunciation, ...]:
    own = recipe.pronunciations.get(word)
    return tuple(tuple(way.split()) for way in own) if own else pronunciations(word)


def without_holes(phones: Tier, duration: float) -> Tier:
    """The same phones, with pauses where nothing stood and up to the end of the sound.

    Examples
    --------
    >>> [(i.label, i.end) for i in without_holes(Tier("phones", (Interval(0.1, 0.2, "M"),)), 0.5)]
    [('SIL', 0.1), ('M', 0.2), ('SIL', 0.5)]
    """
    filled: list[Interval] = []
    now = 0.0
    for interval in phones:
        if interval.start > now + 1e-6:
            filled.append(Interval(now, interval.start, PAUSE))
        filled.append(interval)
        now = interval.end
    if duration > now + 1e-6:
        filled.append(Interval(now, duration, PAUSE))
    return Tier(phones.name, tuple(filled))
