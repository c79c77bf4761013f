"""Forced alignment: a sound and its text in, the times of words and phones out.

pocketsphinx does the work with all pruning off, at 200 frames a second, in two passes; `mien.speech.decoder` keeps
it in a process of its own. With pruning off the work grows with length times words, so a long sound is first
aligned coarsely with pruning on, cut at its pauses, and each piece is then aligned in full.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.audio import Audio
from mien.core.errors import AlignmentError, InputError, Note
from mien.core.timeline import Interval, Tier
from mien.core.utterance import PAUSE, Utterance
from mien.speech.aligned_phone import AlignedPhone
from mien.speech.decoder import RATE, DecodedPhone, DecodedWord, DecoderError, Piece, decode, pcm16
from mien.text.languages import Language, find_language, heard_as, in_english_phones, native_tier
from mien.text.languages.language import ENGLISH
from mien.text.languages.language_detection import note_on_language
from mien.text.languages.reading import read_in
from mien.text.normalisation import spoken_words
from mien.text.pronunciation import Pronunciation, pronunciations
from mien.text.spoken_text import Spelled, SpokenWord, with_spellings

__all__ = ["align", "align_pieces", "align_words", "choices_of", "name_words", "tiers"]

BEST = {"lm": None, "bestpath": False, "beam": 0.0, "wbeam": 0.0, "pbeam": 0.0, "frate": 200}
"""Settings with the least boundary error (see docs/tables/alignment.md)."""
PRUNED = {"lm": None, "bestpath": False, "frate": 100}
"""pocketsphinx's own beams: less exact, but it gets through where the best settings do not."""
WIDE = PRUNED | {"beam": 1e-120, "wbeam": 1e-120, "pbeam": 1e-120}
"""Between the two: for cutting a long sound into pieces."""
LAG = 0.009
"""Seconds by which the decoder's boundaries come early, measured against hand labels."""
LONGEST_PIECE = 20.0
"""Seconds that are aligned in one go without pruning."""
_TARGET_PIECE = 10.0
_MOST_WORD_SECONDS = 60_000.0
"""Words times seconds up to which a coarse alignment may run without pruning: beyond it memory runs to gigabytes."""
_SHORTEST_SOUND = 0.1


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
    phones = align_words(audio, words, [choices_of(word, other) for word in spoken.words])
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
        return (word.phones,) if word.phones else pronunciations(word.text)
    return (heard_as(word.phones or (), language),)


def align_words(audio: Audio, words: Sequence[str], choices: Sequence[Sequence[Pronunciation]]) -> list[AlignedPhone]:
    """Align words whose pronunciations are given; the heart of `align`.

    Parameters
    ----------
    audio : Audio
    words : sequence of str
        Only for messages.
    choices : sequence of sequences of tuple of str
        For each word the pronunciations that the speaker may have used.

    Returns
    -------
    list of AlignedPhone
        In order, pauses among them, without gaps from 0 to the end of the sound.

    Raises
    ------
    AlignmentError
        If no alignment was found.
    """
    samples = pcm16(audio)
    names = name_words(choices)
    table = dict(zip(names, choices, strict=True))
    whole = Piece(0, len(samples), tuple(names))
    pieces = [whole] if audio.duration <= LONGEST_PIECE else _cut(samples, whole, table)
    return align_pieces(samples, pieces, table, audio.duration)


def align_pieces(
    samples: NDArray[np.int16],
    pieces: Sequence[Piece],
    table: Mapping[str, Sequence[Pronunciation]],
    duration: float,
) -> list[AlignedPhone]:
    """Align pieces of a sound whose words are known; a piece without words becomes a pause.

    Parameters
    ----------
    samples : array of int16, shape (n,)
        16 kHz; the pieces cover it in order and without gaps.
    pieces : sequence of Piece
        Words by their names in ``table``.
    table : mapping
        Pronunciations of every name.
    duration : float
        Seconds of the sound.

    Raises
    ------
    AlignmentError
        If no alignment was found for a piece.
    """
    spoken = [piece for piece in pieces if piece.words]
    found = iter(_align_spoken(samples, spoken, table) if spoken else [])
    return _joined([(piece, next(found) if piece.words else ()) for piece in pieces], duration)


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


def name_words(choices: Sequence[Sequence[Pronunciation]]) -> list[str]:
    """A name for each word that the decoder can hold: words with the same pronunciations share one."""
    known: dict[tuple[Pronunciation, ...], str] = {}
    return [known.setdefault(tuple(choice), f"w{len(known)}") for choice in choices]


def _align_spoken(
    samples: NDArray[np.int16], pieces: Sequence[Piece], table: Mapping[str, Sequence[Pronunciation]]
) -> list[tuple[DecodedWord, ...]]:
    """Each piece with the best settings; what fails, once more with the decoder's own."""
    problem = "no path through the sound"
    answers: list[tuple[DecodedWord, ...] | None] = [None] * len(pieces)
    for settings in (BEST, PRUNED):
        open_pieces = [i for i, answer in enumerate(answers) if answer is None]
        try:
            fresh = decode("phones", samples, [pieces[i] for i in open_pieces], settings, table)
        except DecoderError as failure:
            problem = str(failure)
            continue
        for i, answer in zip(open_pieces, fresh, strict=True):
            answers[i] = answer if answer and _is_complete(answer, pieces[i]) else None
        if None not in answers:
            return [answer for answer in answers if answer is not None]
    place = pieces[answers.index(None)]
    raise AlignmentError(
        f"could not align the text ({len(place.words)} words) with the sound between {place.first / RATE:.2f} s and "
        f"{place.last / RATE:.2f} s: {problem}; check that the text is what is said there"
    )


def _is_complete(answer: tuple[DecodedWord, ...], piece: Piece) -> bool:
    return tuple(word.name for word in answer if not word.filler) == piece.words


def _joined(found: Sequence[tuple[Piece, tuple[DecodedWord, ...]]], duration: float) -> list[AlignedPhone]:
    """Phones of all pieces on one clock, neighbouring pauses made one, boundaries moved by `LAG`."""
    labels: list[tuple[str, float, int, float, int]] = []
    number = -1
    for piece, words in found:
        for word in words or (_pause(piece),):
            number += not word.filler
            for phone in word.phones:
                label = PAUSE if word.filler else phone.name
                start = piece.first / RATE + phone.start
                if word.filler and labels and labels[-1][0] == PAUSE:
                    _, first, _, score, frames = labels.pop()
                    labels.append((PAUSE, first, -1, score + phone.score, frames + phone.frames))
                else:
                    labels.append((label, start, -1 if word.filler else number, phone.score, phone.frames))
    starts = [0.0] + [min(start + LAG, duration) for _, start, *_ in labels[1:]] + [duration]
    return [
        AlignedPhone(label, starts[i], starts[i + 1], word, score / max(frames, 1))
        for i, (label, _, word, score, frames) in enumerate(labels)
    ]


def _pause(piece: Piece) -> DecodedWord:
    seconds = (piece.last - piece.first) / RATE
    return DecodedWord("<sil>", 0.0, seconds, True, (DecodedPhone(PAUSE, 0.0, seconds, 1, 0.0),))


# ---- Long sounds -------------------------------------------------------------------------------------------------


def _cut(samples: NDArray[np.int16], whole: Piece, table: dict[str, Sequence[Pronunciation]]) -> list[Piece]:
    """Pieces of about `_TARGET_PIECE` seconds, cut in pauses that a coarse alignment finds."""
    words = _coarse(samples, whole, table)
    gaps = _gaps(words, len(samples) / RATE)
    cuts: list[tuple[int, int]] = [(0, 0)]
    while True:
        here = cuts[-1][0] / RATE
        if len(samples) / RATE - here <= LONGEST_PIECE:
            break
        ahead = [gap for gap in gaps if 2.0 < gap[0] - here <= LONGEST_PIECE]
        if not ahead:
            ahead = [gap for gap in gaps if gap[0] - here > LONGEST_PIECE][:1]
        if not ahead:
            break
        middle, _, index = max(ahead, key=lambda gap: min(gap[1], 0.4) - 0.02 * abs(gap[0] - here - _TARGET_PIECE))
        cuts.append((round(middle * RATE), index))
    cuts.append((len(samples), len(whole.words)))
    return [Piece(first, last, whole.words[word:next_word]) for (first, word), (last, next_word) in pairwise(cuts)]


def _coarse(
    samples: NDArray[np.int16], whole: Piece, table: dict[str, Sequence[Pronunciation]]
) -> tuple[DecodedWord, ...]:
    problem = "no path through the sound"
    attempts: list[dict[str, Any]] = [WIDE]
    if len(whole.words) * len(samples) / RATE <= _MOST_WORD_SECONDS:
        attempts.append(BEST | {"frate": 100})
    for settings in attempts:
        try:
            answer = decode("words", samples, [whole], settings, table)[0]
        except DecoderError as failure:
            problem = str(failure)
            continue
        if answer and _is_complete(answer, whole):
            return answer
    raise AlignmentError(
        f"could not align the text ({len(whole.words)} words) with {len(samples) / RATE:.0f} s of sound: {problem}; "
        "check that the text is what is said, or cut both into shorter parts"
    )


def _gaps(words: Sequence[DecodedWord], duration: float) -> list[tuple[float, float, int]]:
    """Places between two words: middle and length of the pause there in seconds, and the number of the next word."""
    spoken = [word for word in words if not word.filler]
    return [
        ((before.end + after.start) / 2, after.start - before.end, i + 1)
        for i, (before, after) in enumerate(pairwise(spoken))
        if before.end < duration
    ]
