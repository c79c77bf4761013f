"""Speech without a text: phones good enough to animate, and when they are said.

Where the wheel of `hama` runs (Linux, macOS) its phoneme recogniser says what is spoken; elsewhere pocketsphinx
recognises words with its own language model. Either way the result is then aligned like a given text. On hand-made
labels the first is the better one: see docs/tables/alignment.md.
"""

from __future__ import annotations

from functools import cache
from importlib.util import find_spec
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mien.core.assets import asset_table
from mien.core.audio import Audio
from mien.core.errors import AlignmentError, InputError, MissingPartError, Note
from mien.core.long_arrays import LONG, let_go
from mien.core.timeline import Interval, Tier
from mien.core.utterance import PAUSE, Utterance
from mien.speech.align import align_words, tiers
from mien.speech.decoder import RATE, DecoderError, Piece, pcm16, transcribe, words_in
from mien.text.pronunciation import Pronunciation, dictionary_entries, pronunciations

__all__ = ["ipa_phones", "recognise", "recogniser_at_hand"]

Recogniser = Literal["hama", "pocketsphinx"]
Heard = list[list[tuple[str, tuple[Pronunciation, ...]]]]

_LONGEST_PIECE, _SHORTEST_PIECE = 15.0, 7.0
_APPROXIMATE = "no text was given: words and phones were recognised from the sound and are approximate; give the text"


def recogniser_at_hand() -> Recogniser:
    """The better of the recognisers that are installed here."""
    return "hama" if find_spec("hama") is not None else "pocketsphinx"


def recognise(audio: Audio, *, language: str = "en-US", recogniser: Recogniser | None = None) -> Utterance:
    """Find which phones are said in a sound, and when, without its text.

    Parameters
    ----------
    audio : Audio
        Any rate and length.
    language : str
        BCP 47 tag; English only.
    recogniser : {"hama", "pocketsphinx"}, optional
        By default the better one that is installed.

    Returns
    -------
    Utterance
        ``timing`` is ``"recognised"``, with a note that it is approximate. A word that the dictionary does not hold
        is labelled with its phones, such as ``"ih-v-ah-n"``. ``timing`` is ``"none"`` if no speech was found.

    Raises
    ------
    InputError
        If the language is not English or the recogniser is unknown.
    MissingPartError
        If the recogniser asked for is not installed.
    AlignmentError
        If the recogniser or the aligner failed.
    """
    if language.lower().partition("-")[0] != "en":
        raise InputError(f"without a text mien hears English only, not {language!r}: give the text that is spoken")
    recogniser = recogniser or recogniser_at_hand()
    if recogniser not in ("hama", "pocketsphinx"):
        raise InputError(f"a recogniser is 'hama' or 'pocketsphinx', not {recogniser!r}")
    if recogniser == "hama" and find_spec("hama") is None:
        raise MissingPartError("the recogniser hama is not installed: pip install hama==1.7.0 (Linux and macOS)")
    if audio.is_silent():
        return _nothing(audio, language)
    samples = pcm16(audio)
    pieces = _quiet_cuts(samples)
    try:
        heard = _hear_hama(samples, pieces) if recogniser == "hama" else _hear_pocketsphinx(samples, pieces)
    except DecoderError as failure:
        raise AlignmentError(f"the recogniser {recogniser} failed: {failure}; give the text of the sound") from failure
    words = [word for piece in heard for word in piece]
    if audio.duration >= LONG:
        _spellings.cache_clear()  # 50 MB, and what follows needs the room
    if not words:
        return _nothing(audio, language)
    labels = [label for label, _ in words]
    phones = align_words(audio, labels, [choices for _, choices in words])
    word_tier, phone_tier = tiers(phones, labels, audio.duration)
    note = Note("note", f"{_APPROXIMATE} for a better mouth")
    return Utterance(" ".join(labels), audio, word_tier, phone_tier, language, "recognised", (note,))


def _nothing(audio: Audio, language: str) -> Utterance:
    pause = Tier("phones", (Interval(0.0, audio.duration, PAUSE),))
    warning = Note("warning", "no speech was found in the sound: the mouth will rest")
    return Utterance("", audio, Tier("words", ()), pause, language, "none", (warning,))


def _quiet_cuts(samples: NDArray[np.int16]) -> list[Piece]:
    """Pieces of 7 to 15 s, cut in the middle of the quietest 0.2 s."""
    window = RATE // 5
    cuts = [0]
    while len(samples) - cuts[-1] > _LONGEST_PIECE * RATE:
        about = samples[cuts[-1] : cuts[-1] + int(_LONGEST_PIECE * RATE) + window].astype(np.float64)
        power = np.concatenate([[0.0], np.cumsum(about**2)])
        starts = np.arange(int(_SHORTEST_PIECE * RATE), int(_LONGEST_PIECE * RATE), RATE // 100)
        starts = starts[starts + window < len(about)]
        cuts.append(cuts[-1] + int(starts[np.argmin(power[starts + window] - power[starts])]) + window // 2)
        let_go(samples)
    cuts.append(len(samples))
    return [Piece(first, last) for first, last in pairwise(cuts)]


def _hear_hama(samples: NDArray[np.int16], pieces: list[Piece]) -> Heard:
    table = _ipa_table()
    heard: Heard = []
    for words in transcribe(samples, pieces):
        phones = [tuple(phone for sign in word for phone in table.get(sign, ())) for word in words]
        heard.append([(_spelling(word), (word,)) for word in phones if word])
    return heard


def _hear_pocketsphinx(samples: NDArray[np.int16], pieces: list[Piece]) -> Heard:
    return [[(word, pronunciations(word)) for word in words] for words in words_in(samples, pieces)]


def ipa_phones(sign: str) -> tuple[str, ...]:
    """The ARPAbet phones nearest to an IPA sign, marks of length and stress passed over; none if it is not known.

    Examples
    --------
    >>> ipa_phones("aɪ"), ipa_phones("ˈəː"), ipa_phones("?")
    (('AY',), ('AH',), ())
    """
    table = _ipa_table()
    for written in (sign, sign.strip("ˈˌːˑ.")):
        if written in table:
            return table[written]
    return ()


@cache
def _ipa_table() -> dict[str, tuple[str, ...]]:
    return {sign: tuple(phones) for sign, phones in asset_table("phones/ipa_to_arpabet.toml")["phones"].items()}


@cache
def _spellings() -> dict[Pronunciation, str]:
    """The shortest word of each pronunciation."""
    found: dict[Pronunciation, str] = {}
    for word, phones in dictionary_entries():
        if phones not in found or len(word) < len(found[phones]):
            found[phones] = word
    return found


def _spelling(phones: Pronunciation) -> str:
    return _spellings().get(phones) or "-".join(phones).lower()
