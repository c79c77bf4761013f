"""Festival, when it is installed: a separate program, with phone times from its own utterance structure.

It reads Latin-1: text comes here as the spoken words of a language in plain small letters, and `scheme_string` refuses
whatever else might have slipped through.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import soundfile

from mien.core.assets import asset, asset_table
from mien.core.errors import InputError, MissingPartError, Note
from mien.core.external_program import run_program
from mien.core.progress import tell
from mien.core.temporary_folder import temporary_folder
from mien.core.timeline import Interval
from mien.speech.voices.sentences import Sentence, in_groups
from mien.speech.voices.sound_joining import Piece, join_pieces
from mien.speech.voices.voice import Availability, Speech, Voice
from mien.text.languages import find_language
from mien.text.spoken_text import SpokenText

__all__ = ["Festival", "festival_voices", "scheme_string"]

_PROGRAM = "festival"
_LIST_SECONDS = 20.0


class Festival(Voice):
    """One of Festival's voices, American or Finnish.

    Parameters
    ----------
    name : str
        A key of ``[voices]`` in ``assets/voices/festival.toml``.
    """

    engine = "Festival, a separate program"
    own_pronunciation = True
    realign = False

    def __init__(self, name: str) -> None:
        entry = _settings()["voices"][name]
        self.name = name
        self.language: str = entry["language"]
        self.sounds: str = entry["sounds"]
        self.own_language = find_language(self.language)
        self._phones: dict[str, str] = _settings()[entry["phones"]]
        self._letters: dict[str, str] = _settings()["letters"].get(self.language, {})
        self.licence: str = entry["licence"]
        self.lineage: str = entry["lineage"]
        self._command: str = entry["command"]
        self._package: str = entry["package"]

    def availability(self) -> Availability:
        """Whether the program and this voice are installed."""
        if self._command in _installed_voices():
            return Availability(True, f"{shutil.which(_PROGRAM)} with {self._command}")
        return Availability(False, f"on Debian or Ubuntu run: apt install festival {self._package}")

    def _speak(self, sentences: tuple[Sentence, ...], seed: int) -> Speech:
        return join_pieces(self._pieces(sentences))

    def _pieces(self, sentences: tuple[Sentence, ...]) -> Iterator[Piece]:
        spoken = 0
        for group in in_groups(sentences):
            with temporary_folder() as folder:
                waves = [folder / f"{number}.wav" for number in range(len(group))]
                script = folder / "speak.scm"
                script.write_bytes(self._script(group, waves))
                printed = run_program([_PROGRAM, "--batch", str(script)], self.name).decode("latin-1")
                told = printed.split("sentence\n")[1:]
                if len(told) != len(group) or not all(wave.exists() for wave in waves):
                    raise MissingPartError(f"Festival spoke {len(told)} of {len(group)} sentences: reinstall it")
                for wave, lines, sentence in zip(waves, told, group, strict=True):
                    samples, rate = soundfile.read(wave, dtype="float64")
                    yield Piece(samples, rate, *_times(lines, sentence, self._phones), sentence)
            spoken += len(group)
            tell("speaking", spoken, len(sentences))

    def _script(self, sentences: tuple[Sentence, ...], waves: list[Path]) -> bytes:
        functions = asset("voices/festival.scm").read_text(encoding="ascii")
        calls = [
            f"(speak-sentence {scheme_string(self._written(sentence))} {scheme_string(str(wave))})"
            for sentence, wave in zip(sentences, waves, strict=True)
        ]
        return "\n".join([functions, f"(voice_{self._command})", *calls, ""]).encode("latin-1")

    def notes(self, spoken: SpokenText) -> tuple[Note, ...]:
        """Letters that Festival's voice does not know and how they are written for it instead."""
        text = spoken.spoken
        changed = [f"{letter!r} as {known!r}" for letter, known in self._letters.items() if letter in text and known]
        if not changed:
            return ()
        return (Note("note", f"the voice {self.name!r} does not know some letters and reads {', '.join(changed)}"),)

    def _written(self, sentence: Sentence) -> str:
        """The sentence in letters that the voice knows."""
        text = sentence.text
        for letter, known in self._letters.items():
            text = text.replace(letter, known)
        return text


def scheme_string(text: str) -> str:
    r"""A text as a Scheme string that cannot end early; Festival reads Latin-1.

    Raises
    ------
    InputError
        If a character is not in Latin-1.

    Examples
    --------
    >>> print(scheme_string('say "hi") (exit) \\'))
    "say \"hi\") (exit) \\"
    """
    try:
        text.encode("latin-1")
    except UnicodeEncodeError as problem:
        raise InputError(
            f"Festival reads Latin-1 only, and {text[problem.start]!r} is not in it: write it out"
        ) from problem
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", " ") + '"'


def _times(lines: str, sentence: Sentence, table: dict[str, str]) -> tuple[list[Interval], list[Interval]]:
    """Phones, and a word for every token that has any: Festival's tokens are the words we gave it.

    Empty if a phone is not in our table or the tokens are not our words: the sound is aligned then.
    """
    phones: list[Interval] = []
    tokens: list[list[Interval]] = []
    for line in lines.splitlines():
        kind, *rest = line.split()
        if kind == "token":
            tokens.append([])
            continue
        if kind != "phone" or rest[0] not in table:
            return [], []
        phone = Interval(float(rest[1]), float(rest[2]), table[rest[0]])
        phones.append(phone)
        tokens[-1].append(phone)
    spoken = [token for token in tokens if token]
    if len(spoken) != len(sentence.words):
        return [], []
    words = [Interval(t[0].start, t[-1].end, w.text) for t, w in zip(spoken, sentence.words, strict=True)]
    return phones, words


def festival_voices() -> tuple[Festival, ...]:
    """All of Festival's voices that mien knows."""
    return tuple(Festival(name) for name in _settings()["voices"])


@cache
def _installed_voices() -> frozenset[str]:
    if shutil.which(_PROGRAM) is None:
        return frozenset()
    try:
        printed = run_program([_PROGRAM, "--batch", "(print (voice.list))"], _PROGRAM, seconds=_LIST_SECONDS)
    except MissingPartError:
        # A program of this name that does not answer is not a Festival we can speak with.
        return frozenset()
    return frozenset(printed.decode("latin-1").replace("(", " ").replace(")", " ").split())


@cache
def _settings() -> dict[str, Any]:
    return asset_table("voices/festival.toml")
