"""Reading sound from nearly any file: one channel out, with a note on whatever had to be changed."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mien.audio import MAX_RATE, MIN_RATE, Audio
from mien.errors import InputError, Note

__all__ = ["KEPT_RATE", "SHORTEST", "read_audio"]

KEPT_RATE = 48_000
"""Sound above this rate is brought down to it: nothing here needs more."""
SHORTEST = 0.02
"""Seconds; less than this is no sound that anything could speak."""
_TELEPHONE_RATE = 11_025

Samples = NDArray[np.float64]


def read_audio(path: str | Path) -> tuple[Audio, tuple[Note, ...]]:
    """Read a sound file, or the sound track of a video.

    WAV, FLAC, OGG and AIFF are read by libsndfile; all else (MP3, M4A, MP4, MKV, MPG, ...) by FFmpeg's libraries.
    Several channels are averaged, rates above `KEPT_RATE` resampled; both are noted.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    audio : Audio
    notes : tuple of Note

    Raises
    ------
    InputError
        If the file is missing, empty, cut short, or holds no sound.
    """
    path = Path(path)
    samples, rate = _decode(_existing(path))
    notes = []
    if samples.shape[1] > 1:
        notes.append(Note("note", f"{path.name} has {samples.shape[1]} channels: their average is used"))
    if len(samples) < SHORTEST * rate:
        raise InputError(f"{path}: expected at least {SHORTEST} s of sound, got {len(samples) / rate:.3f} s")
    if not MIN_RATE <= rate <= MAX_RATE:
        raise InputError(f"{path}: expected a sample rate between {MIN_RATE} and {MAX_RATE} Hz, got {rate}")
    if not np.isfinite(samples).all():
        bad = int(np.argmax(~np.isfinite(samples).all(axis=1)))
        raise InputError(f"{path}: sample {bad} ({bad / rate:.3f} s) is not a finite number: is the file damaged?")
    mono = samples.mean(axis=1)
    loudest = float(np.abs(mono).max())
    if loudest > 1.0:
        notes.append(Note("note", f"{path.name} peaks at {loudest:.2f} of full scale: turned down to fit"))
        mono = mono / loudest
    audio = Audio(mono, rate)
    if rate > KEPT_RATE:
        notes.append(Note("note", f"{path.name} is sampled at {rate} Hz: brought to {KEPT_RATE} Hz"))
        audio = audio.resampled(KEPT_RATE)
    elif rate <= _TELEPHONE_RATE:
        notes.append(Note("note", f"{path.name} is sampled at {rate} Hz: /s f th/ are hard to place in such sound"))
    return audio, tuple(notes)


def _existing(path: Path) -> Path:
    if path.is_dir():
        raise InputError(f"{path}: expected a sound file, got a folder")
    if not path.exists():
        raise InputError(f"{path}: no such file")
    try:
        size = path.stat().st_size
        with path.open("rb"):
            pass
    except OSError as problem:
        raise InputError(f"{path}: cannot be read ({problem.strerror})") from problem
    if size == 0:
        raise InputError(f"{path}: the file is empty")
    return path


def _decode(path: Path) -> tuple[Samples, int]:
    """Samples of shape (n, channels) and their rate."""
    import soundfile

    _refuse_cut_wav(path)
    try:
        with soundfile.SoundFile(str(path)) as sound:
            if sound.format != "MP3":
                expected = sound.frames
                samples = sound.read(dtype="float64", always_2d=True)
                if len(samples) < expected < 2**40:
                    raise _cut_short(path, len(samples) / sound.samplerate, expected / sound.samplerate)
                return samples, int(sound.samplerate)
    except soundfile.LibsndfileError as problem:
        if path.suffix.lower() in (".flac", ".ogg") and path.open("rb").read(4) in (b"fLaC", b"OggS"):
            raise InputError(f"{path}: the file is damaged or cut short ({problem.error_string.strip()})") from problem
    return _decode_with_av(path)


def _refuse_cut_wav(path: Path) -> None:
    """Raise if a RIFF file promises more sound than it holds (libsndfile would read the rest in silence)."""
    with path.open("rb") as file:
        head = file.read(12)
        if head[:4] != b"RIFF" or head[8:12] != b"WAVE":
            return
        size = path.stat().st_size
        while len(chunk := file.read(8)) == 8:
            name, length = struct.unpack("<4sI", chunk)
            if name == b"data":
                held = size - file.tell()
                unknown = length in (0, 0xFFFFFFFF, 0x7FFFFFFF, 0x7FFFFFFF - 36)  # written by a pipe that never ended
                if length > held and not unknown:
                    raise InputError(
                        f"{path}: the file is cut short: {length} bytes of sound promised, {held} there; copy it again"
                    )
                return
            file.seek(length + length % 2, 1)
    raise InputError(f"{path}: a WAV file without any sound in it: is it cut short?")


def _cut_short(path: Path, got: float, expected: float) -> InputError:
    return InputError(f"{path}: the file is cut short: {expected:.2f} s promised, {got:.2f} s there; copy it again")


def _decode_with_av(path: Path) -> tuple[Samples, int]:
    import av

    pieces: list[Samples] = []
    try:
        with av.open(str(path)) as container:
            if not container.streams.audio:
                raise InputError(f"{path}: expected sound, got a file without a sound track")
            stream = container.streams.audio[0]
            rate, promised = stream.rate, _promised_seconds(stream)
            planar = av.AudioResampler(format="dblp", layout=stream.layout, rate=rate)
            for frame in container.decode(stream):
                pieces += [out.to_ndarray().T.astype(np.float64) for out in planar.resample(frame)]
            pieces += [out.to_ndarray().T.astype(np.float64) for out in planar.resample(None)]
    except av.FFmpegError as problem:
        if not pieces:
            raise InputError(
                f"{path}: expected a sound or video file, got something that no decoder knows"
            ) from problem
        raise InputError(
            f"{path}: the sound breaks off after {sum(map(len, pieces)) / rate:.2f} s: the file is damaged or cut short"
        ) from problem
    samples = np.concatenate(pieces) if pieces else np.zeros((0, 1))
    if promised and len(samples) / rate < promised - 0.5:
        raise _cut_short(path, len(samples) / rate, promised)
    return samples, int(rate)


def _promised_seconds(stream: object) -> float | None:
    duration, base = getattr(stream, "duration", None), getattr(stream, "time_base", None)
    return float(duration * base) if duration and base else None
