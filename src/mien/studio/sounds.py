"""Uploaded sound: measured before it is decoded whole, so that a small file cannot unpack into a huge one."""

from __future__ import annotations

from pathlib import Path

from mien.audio import Audio
from mien.audio_files import read_audio
from mien.errors import InputError, Note
from mien.studio.keeping import new_id
from mien.studio.requests import FieldError
from mien.studio.settings import Limits

__all__ = ["read_sound"]


def read_sound(content: bytes, folder: Path, limits: Limits) -> tuple[Audio, tuple[Note, ...]]:
    """Read an uploaded sound.

    Parameters
    ----------
    content : bytes
        A file of any kind that `mien.audio_files.read_audio` reads.
    folder : Path
        Where it lies while it is read.

    Raises
    ------
    FieldError
        If it cannot be read, or is too long.
    """
    path = folder / f"{new_id()}.sound"
    path.write_bytes(content)
    try:
        seconds = _seconds(path, limits.seconds)
        if seconds > limits.seconds:
            raise InputError(f"the sound is longer than the {limits.seconds:.0f} s that the studio takes")
        audio, notes = read_audio(path)
    except InputError as problem:
        raise FieldError("sound", str(problem).replace(str(path), "the sound")) from problem
    finally:
        path.unlink(missing_ok=True)
    return audio, tuple(Note(note.kind, note.message.replace(path.name, "the sound")) for note in notes)


def _seconds(path: Path, most: float) -> float:
    """Seconds of sound in a file, counted to a little past ``most``; 0 where it cannot be told."""
    import soundfile

    try:
        with soundfile.SoundFile(str(path)) as sound:
            if sound.format != "MP3":
                return float(sound.frames / sound.samplerate)
    except (soundfile.LibsndfileError, RuntimeError):
        pass
    return _decoded_seconds(path, most)


def _decoded_seconds(path: Path, most: float) -> float:
    """Decode and forget, since what a container promises may be wrong."""
    import av

    passed = 0.0
    try:
        with av.open(str(path)) as container:
            if not container.streams.audio:
                return 0.0
            for frame in container.decode(container.streams.audio[0]):
                passed += frame.samples / max(1, frame.sample_rate)
                if passed > most:
                    break
    except (av.FFmpegError, ValueError, OSError):
        return passed
    return passed
