"""The process that runs recognisers: one job in on standard input, one answer out on standard output.

It is a process of its own because a fault in a C library ends the process that it happens in. Nothing but
`mien.speech.decoder` should start it.

Job: one line of JSON, then the sound as 16-bit little-endian samples at 16 kHz. Keys of the job:

``task``    ``"recognise"`` (words, by pocketsphinx) or ``"transcribe"`` (phones, by `hama`)
``pieces``  list of ``[first sample, sample after the last]``

Answer: one line of JSON: for each piece a list of words; of ``"transcribe"``, each a list of IPA signs.
"""

from __future__ import annotations

import json
import sys
from typing import Any

_FILLERS = ("<sil>", "<s>", "</s>", "[NOISE]", "[SPEECH]", "(NULL)")


def main() -> None:
    """Do one job."""
    job = json.loads(sys.stdin.buffer.readline())
    sound = memoryview(sys.stdin.buffer.read())
    pieces = [bytes(sound[2 * first : 2 * last]) for first, last in job["pieces"]]
    answer = _transcribe(pieces) if job["task"] == "transcribe" else _recognise(pieces)
    sys.stdout.write(json.dumps(answer, separators=(",", ":")) + "\n")


def _recognise(pieces: list[bytes]) -> list[list[str]]:
    from pocketsphinx import Decoder

    decoder = Decoder(loglevel="FATAL")
    answers = []
    for samples in pieces:
        decoder.start_utt()
        decoder.process_raw(samples, full_utt=True)
        decoder.end_utt()
        said = [] if decoder.hyp() is None else [part.word for part in decoder.seg() if part.word not in _FILLERS]
        answers.append([word.partition("(")[0] for word in said])
    return answers


def _transcribe(pieces: list[bytes]) -> list[list[list[str]]]:
    import numpy as np
    from hama import ASRModel

    model: Any = ASRModel()
    answers = []
    for samples in pieces:
        result = model(np.frombuffer(samples, dtype="<i2").astype(np.float32) / 32768, 16_000)
        answers.append([word.split() for word in result.word_phoneme_text.split("|")])
    return answers


if __name__ == "__main__":
    main()
