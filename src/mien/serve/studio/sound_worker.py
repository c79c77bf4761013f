"""Decodes one uploaded sound in a process of its own: decoders are large programs in C, and uploads may be hostile.

    python -m mien.serve.studio.sound_worker SOUND MOST_SECONDS OUT.npy

writes the samples (float32) and prints JSON: ``{"rate": ..., "notes": [...]}`` or ``{"error": "one line"}``.
"""

from __future__ import annotations

import contextlib
import json
import sys
from pathlib import Path

import numpy as np

from mien.core.errors import InputError
from mien.formats.media import open_media
from mien.formats.sound_files import read_audio

__all__ = ["main"]


def main(sound: str, most: str, out: str) -> None:
    """Decode; what is longer than ``most`` seconds is refused before it is decoded whole."""
    path = Path(sound)
    try:
        if _seconds(path, float(most)) > float(most):
            raise InputError(f"the sound is longer than the {float(most):.0f} s that the studio takes")
        audio, notes = read_audio(path)
    except InputError as problem:
        print(json.dumps({"error": " ".join(str(problem).split())}))
        return
    np.save(out, audio.samples)
    told = [[note.kind, note.message] for note in notes]
    print(json.dumps({"rate": audio.rate, "notes": told}))


def _seconds(path: Path, most: float) -> float:
    """Seconds of sound in a file, counted to a little past ``most``; 0 where it cannot be told."""
    import soundfile

    try:
        with soundfile.SoundFile(str(path)) as sound:
            if sound.format != "MP3":
                return float(sound.frames / sound.samplerate)
    except (soundfile.LibsndfileError, RuntimeError):
        return _decoded_seconds(path, most)
    return _decoded_seconds(path, most)


def _decoded_seconds(path: Path, most: float) -> float:
    """Decode and forget, since what a container promises may be wrong."""
    passed = 0.0
    with contextlib.suppress(InputError), open_media(path) as container:  # `read_audio` says what is wrong with it
        for frame in container.decode(container.streams.audio[0]) if container.streams.audio else ():
            passed += frame.samples / max(1, frame.sample_rate)
            if passed > most:
                break
    return passed


if __name__ == "__main__":
    main(*sys.argv[1:])
