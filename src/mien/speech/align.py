"""Forced alignment: a sound and its text in, the times of words and phones out.

The network of `mien live` hears how likely each phone is in each row of 10 ms (`mien.speech.hearing`): it learned in
noise, and what it cannot hear it holds for possible. `mien.speech.text_search` finds the likeliest way through the
text.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from mien.core.audio import Audio
from mien.core.errors import AlignmentError, InputError, Note
from mien.core.timeline import Interval, Tier
from mien.core.utterance import PAUSE, Utterance
from mien.speech.aligned_phone import AlignedPhone
from mien.speech.connected_speech import heard_pronunciations
from mien.speech.hearing import Hearing, hear
from mien.speech.streaming_features import HOP, RATE
from mien.speech.text_search import OTHER, Found, TextGraph, search
from mien.text.languages import Language, find_language, heard_as, in_english_phones, native_tier
from mien.text.languages.language import ENGLISH
from mien.text.languages.reading import note_on_language, read_in
from mien.text.normalisation import spoken_words
from mien.text.pronunciation import Pronunciation
from mien.text.spoken_text import Spelled, SpokenWord, with_spellings

__all__ = ["align", "align_words", "choices_of", "tiers"]

_SHORTEST_SOUND = 0.1
_MOST_PHONE_SECONDS = 100_000.0
"""Phones times seconds up to which every way is followed where none near the best one leads to the end of a text."""


def align(audio: Audio, text: str, *, language: str | Path = ENGLISH, spellings: Sequence[Spelled] = ()) -> Utterance:
    """Find when each word and phone of a text is said in a sound.

    Parameters
    ----------
    audio : Audio
        Any rate.
    text : str
        What is said, as one writes it: numbers and abbreviations are read as `spoken_words` reads them.
    language : str or Path
        BCP 47 tag: English (``"en"`` or ``"en-..."``) or one of `mien.text.languages.known_languages`; or a phone map
        of another language, ``"X.toml"``. Another language is aligned with the English acoustic model through its map.
    spellings : sequence of (start, end, phones)
        Characters of the text and the ARPAbet phones with which they are said. English only; elsewhere it is a note.

    Returns
    -------
    Utterance
        ``timing`` is ``"aligned"``; word ``i`` of the words tier is word ``i`` of ``spoken_words(text).words``, which
        knows the written text that it stands for. ``timing`` is ``"none"``, with one pause and a warning, if the
        sound is silent. Stretches where text and sound do not seem to fit have a warning each.

    Raises
    ------
    InputError
        If the text cannot be spoken, the language is not known, or the sound is shorter than 0.1 s.
    MissingPartError
        If the language is read by eSpeak NG and it is not installed.
    AlignmentError
        If no alignment was found.
    """
    from mien.speech.transcript_doubts import LOWEST_RUN_SCORE, LOWEST_RUN_SCORE_THROUGH_A_MAP, doubts

    other = find_language(language)
    if audio.duration < _SHORTEST_SOUND:
        raise InputError(f"a sound to align lasts at least {_SHORTEST_SOUND} s, this one {audio.duration:.3f} s")
    spoken = spoken_words(text) if other is None else read_in(other, text)
    if other is None:
        spoken = with_spellings(spoken, spellings)
    elif spellings:
        note = Note("note", f"pronunciations that are asked for are not followed in {other.name}")
        spoken = replace(spoken, notes=(*spoken.notes, note))
    tag = str(language) if other is None else other.tag
    if audio.is_silent():
        return _silent(audio, text, tag, spoken.notes)
    words = [word.text for word in spoken.words]
    phones = align_words(audio, words, [choices_of(word, other) for word in spoken.words], connected=other is None)
    word_tier, phone_tier = tiers(phones, words, audio.duration)
    notes = spoken.notes + doubts(
        audio, spoken, phones, LOWEST_RUN_SCORE if other is None else LOWEST_RUN_SCORE_THROUGH_A_MAP
    )
    if other is None:
        notes += note_on_language(text)
        return Utterance(text, audio, word_tier, phone_tier, tag, "aligned", notes)
    native = native_tier(phones, [word.phones or () for word in spoken.words], other)
    phone_tier, shapes = in_english_phones(native, other)
    return Utterance(text, audio, word_tier, phone_tier, tag, "aligned", notes, native=native, shapes=shapes)


def choices_of(word: SpokenWord, language: Language | None) -> tuple[Pronunciation, ...]:
    """What the acoustic model is to look for in a word: each pronunciation that the speaker may have used."""
    if language is None:
        return (word.phones,) if word.phones else heard_pronunciations(word.text)
    return (heard_as(word.phones or (), language),)


def align_words(
    audio: Audio, words: Sequence[str], choices: Sequence[Sequence[Pronunciation]], connected: bool = False
) -> list[AlignedPhone]:
    """Align words whose pronunciations are given; the heart of `align`.

    Parameters
    ----------
    audio : Audio
    words : sequence of str
        Only for messages.
    choices : sequence of sequences of tuple of str
        For each word the pronunciations that the speaker may have used.
    connected : bool
        Whether words may change where they meet (`mien.speech.connected_speech`).

    Returns
    -------
    list of AlignedPhone
        In order, pauses among them, without gaps from 0 to the end of the sound.

    Raises
    ------
    AlignmentError
        If no alignment was found.
    """
    heard = hear(audio)
    graph = TextGraph(choices, heard.labels, connected)
    found = search(heard.rows, graph)
    if found is None and audio.duration * len(graph.labels) < _MOST_PHONE_SECONDS:
        found = search(heard.rows, graph, float("inf"))  # a text that is hardly what is said
    if found is None:
        raise AlignmentError(
            f"could not align the text ({len(words)} words) with {audio.duration:.1f} s of sound: there is no way "
            "through it; check that the text is what is said"
        )
    return _phones(found, heard, audio.duration)


def _phones(found: Sequence[Found], heard: Hearing, duration: float) -> list[AlignedPhone]:
    """What was found in seconds, other speech among the pauses, neighbouring pauses made one."""
    row = HOP / RATE
    joined: list[tuple[Found, float]] = []
    for part in found:
        other = (part.last - part.first) * row if part.label == OTHER else 0.0
        label = PAUSE if part.label == OTHER else part.label
        if label == PAUSE and joined and joined[-1][0].label == PAUSE:
            before, longest = joined.pop()
            joined.append((replace(before, last=part.last), max(longest, other)))
        else:
            joined.append((replace(part, label=label), other))
    edges = [heard.edge(after.first, before.label, after.label) for (before, _), (after, _) in pairwise(joined)]
    edges = [0.0, *np.maximum.accumulate(np.clip(edges, 0.0, duration)).tolist(), duration]
    return [
        AlignedPhone(part.label, start, end, part.word, heard.score(part.label, part.first, part.last), other)
        for (part, other), (start, end) in zip(joined, pairwise(edges), strict=True)
    ]


def tiers(phones: Sequence[AlignedPhone], words: Sequence[str], duration: float) -> tuple[Tier, Tier]:
    """The words tier and the phones tier of aligned phones."""
    spans: dict[int, tuple[float, float]] = {}
    for phone in phones:
        if phone.word >= 0:
            spans[phone.word] = (spans.get(phone.word, (phone.start, 0.0))[0], phone.end)
    word_tier = Tier("words", tuple(Interval(*spans[i], words[i]) for i in sorted(spans)))
    return word_tier, Tier("phones", tuple(Interval(p.start, p.end, p.label) for p in phones))


def _silent(audio: Audio, text: str, language: str, notes: tuple[Note, ...]) -> Utterance:
    warning = Note("warning", "the sound is silent: its text was not aligned, and the mouth will rest")
    pause = Tier("phones", (Interval(0.0, audio.duration, PAUSE),))
    return Utterance(text, audio, Tier("words", ()), pause, language, "none", (*notes, warning))
