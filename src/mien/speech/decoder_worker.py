"""The process that runs pocketsphinx: one job in on standard input, one answer out on standard output.

It is a process of its own because a fault in the C library ends the process that it happens in. Nothing but
`mien.speech.decoder` should start it.

Job: one line of JSON, then the sound as 16-bit little-endian samples at 16 kHz. Keys of the job:

``task``        ``"phones"`` (words and phones of a text), ``"words"`` (only words, one pass, faster),
                ``"recognise"`` (words without a text) or ``"transcribe"`` (by `hama`: phones without a text)
``settings``    keyword arguments of `pocketsphinx.Decoder`
``dictionary``  path of a dictionary file, or null for the one inside pocketsphinx
``pieces``      list of ``{"first": sample, "last": sample, "words": [names]}``

Answer: one line of JSON: for each piece a list of ``[name, start, frames, score, phones]``, where ``phones`` is a
list of ``[name, start, frames, score]``; or null where the decoder found no path. Times count in frames from the
start of the piece. ``"transcribe"`` answers with a list of words for each piece, a word being a list of IPA signs.
"""

from __future__ import annotations

import json
import sys
from typing import Any


def main() -> None:
    """Do one job."""
    header = sys.stdin.buffer.readline()
    job = json.loads(header)
    sound = memoryview(sys.stdin.buffer.read())
    answer = run(job, sound)
    sys.stdout.write(json.dumps(answer, separators=(",", ":")) + "\n")


def run(job: dict[str, Any], sound: memoryview) -> list[Any]:
    """Decode every piece of a job."""
    if job["task"] == "transcribe":
        return _transcribe(job["pieces"], sound)
    from pocketsphinx import Decoder

    settings = dict(job["settings"])
    if job["dictionary"] is not None:
        settings["dict"] = job["dictionary"]
    decoder = Decoder(loglevel="FATAL", **settings)
    return [_decode(decoder, job["task"], piece, sound) for piece in job["pieces"]]


def _decode(decoder: Any, task: str, piece: dict[str, Any], sound: memoryview) -> list[Any] | None:
    samples = bytes(sound[2 * piece["first"] : 2 * piece["last"]])
    if task != "recognise":
        decoder.set_align_text(" ".join(piece["words"]))
    _listen(decoder, samples)
    if decoder.hyp() is None:
        return None
    if task != "phones":
        return [[part.word, part.start_frame, part.end_frame - part.start_frame + 1, 0, []] for part in decoder.seg()]
    decoder.set_alignment()
    _listen(decoder, samples)
    alignment = decoder.get_alignment()
    if alignment is None:
        return None
    # The entries are only valid while the iteration stands on them: a list of them, read later, ends the process.
    return [
        [word.name, word.start, word.duration, word.score, [[p.name, p.start, p.duration, p.score] for p in word]]
        for word in alignment
    ]


def _transcribe(pieces: list[dict[str, Any]], sound: memoryview) -> list[list[list[str]]]:
    import numpy as np
    from hama import ASRModel

    model = ASRModel()
    answers = []
    for piece in pieces:
        samples = np.frombuffer(sound[2 * piece["first"] : 2 * piece["last"]], dtype="<i2")
        result = model(samples.astype(np.float32) / 32768, 16_000)
        answers.append([word.split() for word in result.word_phoneme_text.split("|")])
    return answers


def _listen(decoder: Any, samples: bytes) -> None:
    decoder.start_utt()
    decoder.process_raw(samples, full_utt=True)
    decoder.end_utt()


if __name__ == "__main__":
    main()
