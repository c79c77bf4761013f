"""eSpeak NG as a separate program (GPL-3): small, very fast, robotic, with exact phone times.

Its library is never loaded into this process: `espeak_process.py` is run by itself and talks through its standard
input and output.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from mien.core.assets import asset_table
from mien.core.progress import tell
from mien.core.timeline import Interval
from mien.core.utterance import PAUSE
from mien.speech.voices.sentences import Sentence, Word, in_groups
from mien.speech.voices.sound_joining import Piece, join_pieces
from mien.speech.voices.voice import Availability, Speech, Voice
from mien.text.languages import Language, find_language, known_languages
from mien.text.languages.espeak_program import HINT, ask_espeak, espeak_library

__all__ = ["Espeak", "EspeakLanguage", "espeak_languages", "words_in_time"]

_STRESS_SIGNS = "',%="
_IPA_STRESS = "ˈˌ"
_DEFAULT_SPEED = 150
_LEAST_PAUSE = 0.08
"""Seconds; a shorter silence inside a word is no pause."""


class Espeak(Voice):
    """eSpeak NG, American English."""

    name = "espeak"
    sounds = "male"
    language = "en-US"
    engine = "eSpeak NG, formant synthesis, a separate process"
    licence = "GPL-3.0-or-later (the engine; run as a separate program)"
    lineage = "rules and formant tables written by hand by the eSpeak NG authors"
    own_pronunciation = True
    realign = False

    def __init__(self) -> None:
        self.feeling = _settings()["feeling"]

    def availability(self) -> Availability:
        """Whether its library is found: in the pip package ``espeakng-loader`` or on the system."""
        return _availability()

    def _speak(self, sentences: tuple[Sentence, ...], seed: int) -> Speech:
        settings = _settings()
        request = {"voice": settings["voice"], "speed": settings["words_per_minute"]}
        return _spoken(request, sentences, self.name, lambda names: [_english(name) for name in names])


class EspeakLanguage(Voice):
    """eSpeak NG in another language; its phones are in IPA."""

    engine = "eSpeak NG, formant synthesis, a separate process"
    licence = Espeak.licence
    lineage = Espeak.lineage
    own_pronunciation = True
    realign = False

    def __init__(self, language: Language) -> None:
        self.name = f"espeak-{language.tag}"
        self.sounds = "male"
        self.language = language.tag
        self.own_language = language
        self.feeling = _settings()["feeling"]
        self._request = {
            "voice": language.espeak,
            "speed": int(language.table.get("words_per_minute", _DEFAULT_SPEED)),
            "ipa": True,
        }

    def availability(self) -> Availability:
        """Whether eSpeak NG's library is found."""
        return _availability()

    def _speak(self, sentences: tuple[Sentence, ...], seed: int) -> Speech:
        return _spoken(self._request, sentences, self.name, lambda names: [_native(name) for name in names])


def espeak_languages() -> tuple[EspeakLanguage, ...]:
    """A voice for every language of mien's that eSpeak NG speaks."""
    languages = [find_language(tag) for tag in known_languages()]
    return tuple(EspeakLanguage(language) for language in languages if language is not None and language.espeak)


def _availability() -> Availability:
    found = espeak_library()
    return Availability(False, HINT) if found is None else Availability(True, f"library {Path(found[0]).name} found")


Labels = Callable[[Sequence[str]], Sequence[Sequence[str] | None]]
"""The engine's phones to ours: none for what is no sound of its own, None for what is not known."""


def _spoken(request: dict[str, Any], sentences: tuple[Sentence, ...], voice: str, labels: Labels) -> Speech:
    return join_pieces(_pieces(request, sentences, voice, labels))


def _pieces(request: dict[str, Any], sentences: tuple[Sentence, ...], voice: str, labels: Labels) -> Iterator[Piece]:
    spoken = 0
    for group in in_groups(sentences):
        answer, raw = ask_espeak(request | {"sentences": [sentence.text for sentence in group]}, voice)
        first = 0
        for sentence, part in zip(group, answer["sentences"], strict=True):
            samples = np.frombuffer(raw, np.int16, part["samples"], 2 * first).astype(np.float64) / 32768
            first += part["samples"]
            yield _piece(sentence, part, samples, answer["rate"], labels)
        spoken += len(group)
        tell("speaking", spoken, len(sentences))


def _english(name: str) -> Sequence[str] | None:
    known: Sequence[str] | None = _settings()["phones"].get(name.lstrip(_STRESS_SIGNS))
    return known


def _native(name: str) -> Sequence[str]:
    """An IPA sign as it is; the engine marks a pause by an empty one, words of another language by ``(en)``."""
    return [] if name.startswith("(") else [name.strip(_IPA_STRESS) or PAUSE]


def _piece(
    sentence: Sentence,
    part: dict[str, Any],
    samples: np.ndarray[Any, np.dtype[np.float64]],
    rate: int,
    labels: Labels,
) -> Piece:
    """One sentence; without times if a phone's name is not known."""
    known = labels([name for _, name in part["phones"]])
    phones: list[Interval] = []
    places = [place / rate for place, _ in part["phones"]] + [part["samples"] / rate]
    for names, (start, end) in zip(known, pairwise(places), strict=True):
        if names is None:
            return Piece(samples, rate, (), (), sentence)
        if names:
            edges = np.linspace(start, end, len(names) + 1).tolist()
            phones += [Interval(a, b, label) for label, (a, b) in zip(names, pairwise(edges), strict=True)]
        elif phones:
            phones[-1] = Interval(phones[-1].start, end, phones[-1].label)
    phones = [phone for phone in phones if phone.label != PAUSE and phone.duration > 0]
    starts = {character: place / rate for place, character in part["words"]}
    words = words_in_time(sentence.words, _characters(sentence), starts, phones)
    return Piece(samples, rate, _joined(phones, words), words, sentence)


def _joined(phones: Sequence[Interval], words: Sequence[Interval]) -> list[Interval]:
    """Phones without the moment of silence before a trill inside a word (Italian *grazie*): it is the stop's."""
    found = list(phones)
    for place, (one, after) in enumerate(pairwise(phones)):
        inside = any(word.start < one.end and after.start < word.end for word in words)
        if inside and 0 < after.start - one.end < _LEAST_PAUSE:
            found[place] = Interval(one.start, after.start, one.label)
    return found


def _characters(sentence: Sentence) -> list[int]:
    """Where each word starts in `Sentence.text`."""
    places, here = [], 0
    for word in sentence.words:
        places.append(here)
        here += len(word.plain) + len(word.mark) + 1
    return places


def words_in_time(
    words: Sequence[Word], characters: Sequence[int], starts: dict[int, float], phones: Sequence[Interval]
) -> list[Interval]:
    """Every word's interval, from the starts that the engine told for some of them.

    The engine says small words together ("of the") and tells one start: the stretch is shared out by the words'
    numbers of phones. No phone is in two words; words that are told when all phones are taken share those before.
    """
    told = [number for number, character in enumerate(characters) if number == 0 or character in starts]
    found: list[Interval] = []
    stretches: list[tuple[int, int, float, float]] = []
    free = list(phones)
    for first, after in pairwise([*told, len(words)]):
        start = starts.get(characters[first], 0.0)
        end = starts[characters[after]] if after < len(words) else float("inf")
        # A word starts at the phone nearest to what was told, which may be a few milliseconds early or late.
        inside = [phone for phone in free if start <= phone.middle < end]
        if not inside and free:
            inside = [min(free, key=lambda phone: abs(phone.start - start))]
        if inside:
            stretches.append((first, after, inside[0].start, inside[-1].end))
            free = [phone for phone in free if phone.start >= inside[-1].end]
        elif stretches:
            stretches[-1] = (stretches[-1][0], after, *stretches[-1][2:])
    for first, after, begin, end in stretches:
        shares = np.cumsum([0, *(len(word.phones) for word in words[first:after])])
        edges = np.interp(shares / shares[-1], [0.0, 1.0], [begin, end]).tolist()
        found += [Interval(a, b, word.text) for word, (a, b) in zip(words[first:after], pairwise(edges), strict=True)]
    return found


@cache
def _settings() -> dict[str, Any]:
    return asset_table("voices/espeak.toml")
