"""Running pocketsphinx in a process of its own, with a time limit: a crash or a hang in it costs one answer."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.audio import Audio
from mien.text.pronunciation import Pronunciation

__all__ = ["RATE", "DecodedPhone", "DecodedWord", "DecoderError", "Piece", "decode", "pcm16", "transcribe"]

RATE = 16_000
"""Samples per second that the acoustic model was made for."""
_COMMAND = [sys.executable, "-m", "mien.speech.decoder_worker"]
_BLOCK = 2**20
_SECONDS_TO_START = 30.0
_SECONDS_PER_SECOND = 8.0
_FILLERS = ("<sil>", "<s>", "</s>", "[NOISE]", "[SPEECH]", "(NULL)")


class DecoderError(Exception):
    """The decoder's process ended badly; the text says how. Caught inside `mien.speech`."""


@dataclass(frozen=True)
class Piece:
    """A stretch of sound, in samples, and the names of the words in it."""

    first: int
    last: int
    words: tuple[str, ...] = ()


@dataclass(frozen=True)
class DecodedPhone:
    """A phone in seconds from the start of its piece; ``score`` is the log likelihood of its frames together."""

    name: str
    start: float
    end: float
    frames: int
    score: float


@dataclass(frozen=True)
class DecodedWord:
    """A word in seconds from the start of its piece; ``filler`` says that it is a pause or a noise."""

    name: str
    start: float
    end: float
    filler: bool
    phones: tuple[DecodedPhone, ...]


def pcm16(audio: Audio) -> NDArray[np.int16]:
    """The sound as the decoder takes it: 16 kHz, 16 bit."""
    samples = audio.resampled(RATE).samples
    found = np.empty(len(samples), dtype=np.int16)
    for start in range(0, len(samples), _BLOCK):
        found[start : start + _BLOCK] = np.round(samples[start : start + _BLOCK].astype(np.float64) * 32767)
    return found


def decode(
    task: str,
    samples: NDArray[np.int16],
    pieces: Sequence[Piece],
    settings: Mapping[str, Any],
    pronunciations: Mapping[str, Sequence[Pronunciation]] | None = None,
) -> list[tuple[DecodedWord, ...] | None]:
    """Run one job of `mien.speech.decoder_worker`.

    Parameters
    ----------
    task : {"phones", "words", "recognise"}
    samples : array of int16, shape (n,)
        16 kHz.
    pieces : sequence of Piece
    settings : mapping
        Keyword arguments of `pocketsphinx.Decoder`.
    pronunciations : mapping, optional
        All words that the decoder shall know; by default its own dictionary.

    Returns
    -------
    list
        For each piece its words, pauses among them, or None where no path was found.

    Raises
    ------
    DecoderError
        If the process crashed, ran out of time, or gave no answer.
    """
    with tempfile.TemporaryDirectory(prefix="mien-") as folder:
        dictionary = None
        if pronunciations is not None:
            dictionary = Path(folder) / "words.dict"
            dictionary.write_text(_dictionary_text(pronunciations), encoding="ascii")
        answer = _ask(task, samples, pieces, settings, dictionary)
    frame = 1.0 / settings.get("frate", 100)
    return [None if words is None else tuple(_word(word, frame) for word in words) for words in answer]


def transcribe(samples: NDArray[np.int16], pieces: Sequence[Piece]) -> list[list[list[str]]]:
    """What `hama` hears in each piece: words, each a list of IPA signs.

    Raises
    ------
    DecoderError
        As `decode` does.
    """
    return _ask("transcribe", samples, pieces, {}, None)


def _ask(
    task: str, samples: NDArray[np.int16], pieces: Sequence[Piece], settings: Mapping[str, Any], dictionary: Path | None
) -> list[Any]:
    job = {
        "task": task,
        "settings": dict(settings),
        "dictionary": None if dictionary is None else str(dictionary),
        "pieces": [{"first": piece.first, "last": piece.last, "words": piece.words} for piece in pieces],
    }
    message = json.dumps(job).encode() + b"\n" + samples.astype("<i2").tobytes()
    limit = _SECONDS_TO_START + _SECONDS_PER_SECOND * len(samples) / RATE
    try:
        done = subprocess.run(_COMMAND, input=message, capture_output=True, timeout=limit, check=False)
    except subprocess.TimeoutExpired as problem:
        raise DecoderError(f"it took longer than {limit:.0f} s") from problem
    if done.returncode < 0:
        raise DecoderError(f"it crashed (signal {-done.returncode})")
    if done.returncode > 0:
        last = done.stderr.decode(errors="replace").strip().splitlines()[-1:] or ["no message"]
        raise DecoderError(f"it stopped: {last[0]}")
    try:
        answer = json.loads(done.stdout)
    except ValueError as problem:
        raise DecoderError("it gave no answer") from problem
    return list(answer)


def _dictionary_text(pronunciations: Mapping[str, Sequence[Pronunciation]]) -> str:
    lines = []
    for name, choices in pronunciations.items():
        for number, phones in enumerate(choices, start=1):
            lines.append(f"{name}{f'({number})' if number > 1 else ''} {' '.join(phones)}\n")
    return "".join(lines)


def _word(entry: Sequence[Any], frame: float) -> DecodedWord:
    name, start, frames, _, phones = entry
    return DecodedWord(
        name.partition("(")[0] if not name.startswith("(") else name,
        start * frame,
        (start + frames) * frame,
        name in _FILLERS,
        tuple(DecodedPhone(p, s * frame, (s + n) * frame, n, score) for p, s, n, score in phones),
    )
