"""eSpeak NG as a separate program (GPL-3): small, very fast, robotic, with exact phone times.

Its library is never loaded into this process: `espeak_process.py` is run by itself and talks through its standard
input and output.
"""

from __future__ import annotations

import ctypes.util
import json
import sys
import tomllib
from collections.abc import Sequence
from functools import cache
from importlib.resources import files
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from mien.errors import MissingPartError
from mien.speech.utterance import PAUSE
from mien.speech.voices.joining import Piece, join_pieces
from mien.speech.voices.programs import run_program
from mien.speech.voices.sentences import Sentence, Word
from mien.speech.voices.voice import Availability, Speech, Voice
from mien.timeline import Interval

__all__ = ["Espeak", "words_in_time"]

_PACKAGE = "espeakng_loader"
_STRESS_SIGNS = "',%="


class Espeak(Voice):
    """eSpeak NG, American English."""

    name = "espeak"
    language = "en-US"
    engine = "eSpeak NG, formant synthesis, a separate process"
    licence = "GPL-3.0-or-later (the engine; run as a separate program)"
    lineage = "rules and formant tables written by hand by the eSpeak NG authors"
    own_pronunciation = True
    realign = False

    def availability(self) -> Availability:
        """Whether its library is found: in the pip package ``espeakng-loader`` or on the system."""
        found = _library()
        if found is None:
            return Availability(False, "run: pip install espeakng-loader (GPL-3) or apt install espeak-ng")
        return Availability(True, f"library {Path(found[0]).name} found")

    def _speak(self, sentences: tuple[Sentence, ...], seed: int) -> Speech:
        found = _library()
        if found is None:
            raise MissingPartError(f"the library of eSpeak NG went away: {self.availability().hint}")
        settings = _settings()
        request = {
            "library": found[0],
            "data": found[1],
            "voice": settings["voice"],
            "speed": settings["words_per_minute"],
            "sentences": [sentence.text for sentence in sentences],
        }
        script = str(Path(__file__).with_name("espeak_process.py"))
        given = json.dumps(request).encode("ascii") + b"\n"
        head, _, raw = run_program([sys.executable, "-I", script], self.name, given).partition(b"\n")
        answer = json.loads(head)
        sound = np.frombuffer(raw, dtype=np.int16).astype(np.float64) / 32768
        counts = [part["samples"] for part in answer["sentences"]]
        chunks = np.split(sound, np.cumsum(counts)[:-1])
        pieces = [
            _piece(sentence, part, chunk, answer["rate"])
            for sentence, part, chunk in zip(sentences, answer["sentences"], chunks, strict=True)
        ]
        if not all(piece.phones for piece in pieces):
            pieces = [Piece(piece.samples, (), (), piece.sentence) for piece in pieces]
        return join_pieces(pieces, answer["rate"])


def _piece(
    sentence: Sentence, part: dict[str, Any], samples: np.ndarray[Any, np.dtype[np.float64]], rate: int
) -> Piece:
    """One sentence; without times if a phone's name is not in our table."""
    table = _settings()["phones"]
    names = [name.lstrip(_STRESS_SIGNS) for _, name in part["phones"]]
    if any(name not in table for name in names):
        return Piece(samples, (), (), sentence)
    phones: list[Interval] = []
    places = [place / rate for place, _ in part["phones"]] + [part["samples"] / rate]
    for name, (start, end) in zip(names, pairwise(places), strict=True):
        if table[name]:
            edges = np.linspace(start, end, len(table[name]) + 1).tolist()
            phones += [Interval(a, b, label) for label, (a, b) in zip(table[name], pairwise(edges), strict=True)]
        elif phones:
            phones[-1] = Interval(phones[-1].start, end, phones[-1].label)
    phones = [phone for phone in phones if phone.label != PAUSE and phone.duration > 0]
    starts = {character: place / rate for place, character in part["words"]}
    return Piece(samples, phones, words_in_time(sentence.words, _characters(sentence), starts, phones), sentence)


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
    numbers of phones.
    """
    told = [number for number, character in enumerate(characters) if number == 0 or character in starts]
    found: list[Interval] = []
    for first, after in pairwise([*told, len(words)]):
        start = starts.get(characters[first], 0.0)
        end = starts[characters[after]] if after < len(words) else float("inf")
        # A word starts at the phone nearest to what was told, which may be a few milliseconds early or late.
        inside = [phone for phone in phones if start <= phone.middle < end]
        if not inside:
            inside = [min(phones, key=lambda phone: abs(phone.start - start))]
        shares = np.cumsum([0, *(len(word.phones) for word in words[first:after])])
        edges = np.interp(shares / shares[-1], [0.0, 1.0], [inside[0].start, inside[-1].end]).tolist()
        found += [Interval(a, b, word.text) for word, (a, b) in zip(words[first:after], pairwise(edges), strict=True)]
    return found


@cache
def _library() -> tuple[str, str] | None:
    """The library and its data folder (``""``: the library knows), or None."""
    package = find_spec(_PACKAGE)
    if package is not None and package.submodule_search_locations:
        folder = Path(package.submodule_search_locations[0])
        names = {"win32": "espeak-ng.dll", "darwin": "libespeak-ng.dylib"}
        library = folder / names.get(sys.platform, "libespeak-ng.so")
        if library.exists():
            return str(library), str(folder / "espeak-ng-data")
    system = ctypes.util.find_library("espeak-ng")
    return (system, "") if system else None


@cache
def _settings() -> dict[str, Any]:
    return tomllib.loads((files("mien") / "assets" / "voices" / "espeak.toml").read_text(encoding="utf-8"))
