"""Running recognisers in a process of their own, with a time limit: a crash or a hang in one costs one answer."""

from __future__ import annotations

import json
import subprocess
import sys
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.audio import Audio
from mien.core.long_arrays import LONG, let_go, long_array
from mien.core.progress import tell

__all__ = ["RATE", "DecoderError", "Piece", "pcm16", "transcribe", "words_in"]

RATE = 16_000
"""Samples per second that the recognisers were made for."""
_COMMAND = [sys.executable, "-m", "mien.speech.decoder_worker"]
_BLOCK = 2**20
_SECONDS_TO_START = 30.0
_SECONDS_PER_SECOND = 8.0


class DecoderError(Exception):
    """The decoder's process ended badly; the text says how. Caught inside `mien.speech`."""


@dataclass(frozen=True)
class Piece:
    """A stretch of sound, in samples."""

    first: int
    last: int


def pcm16(audio: Audio) -> NDArray[np.int16]:
    """The sound as the decoder takes it: 16 kHz, 16 bit."""
    samples = audio.resampled(RATE).samples
    found = _room(len(samples))
    for start in range(0, len(samples), _BLOCK):
        found[start : start + _BLOCK] = np.round(samples[start : start + _BLOCK].astype(np.float64) * 32767)
        let_go(samples)
        let_go(found)
    return found


def _room(count: int) -> NDArray[np.int16]:
    if count < LONG * RATE:
        return np.empty(count, np.int16)
    return np.frombuffer(long_array((count + 1) // 2), np.int16, count)


def words_in(samples: NDArray[np.int16], pieces: Sequence[Piece]) -> list[list[str]]:
    """The words that pocketsphinx hears in each piece, with its own language model.

    Raises
    ------
    DecoderError
        If the process crashed, ran out of time, or gave no answer.
    """
    return _ask("recognise", samples, pieces)


def transcribe(samples: NDArray[np.int16], pieces: Sequence[Piece]) -> list[list[list[str]]]:
    """What `hama` hears in each piece: words, each a list of IPA signs.

    Raises
    ------
    DecoderError
        As `words_in` does.
    """
    return _ask("transcribe", samples, pieces)


def _ask(task: str, samples: NDArray[np.int16], pieces: Sequence[Piece]) -> list[Any]:
    """What one process after another answers: each gets as much as is not long."""
    answers: list[Any] = []
    waiting = list(pieces)
    while waiting:
        begin = waiting[0].first
        count = max(1, bisect_right(waiting, begin + LONG * RATE, key=lambda piece: piece.last))
        now, waiting = waiting[:count], waiting[count:]
        here = [Piece(piece.first - begin, piece.last - begin) for piece in now]
        answers += _answer(task, samples[begin : now[-1].last], here)
        let_go(samples)
        tell("listening", len(answers), len(pieces))
    return answers


def _answer(task: str, samples: NDArray[np.int16], pieces: Sequence[Piece]) -> list[Any]:
    job = {"task": task, "pieces": [[piece.first, piece.last] for piece in pieces]}
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
