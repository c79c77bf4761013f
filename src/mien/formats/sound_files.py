"""Reading sound from nearly any file: one channel out, with a note on whatever had to be changed."""

from __future__ import annotations

import io
import struct
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mien.core.audio import MAX_RATE, MIN_RATE, Audio
from mien.core.border import reading
from mien.core.errors import InputError, Note
from mien.core.limits import check_begun, check_size, read_bytes
from mien.core.long_arrays import LONG, let_go, long_array
from mien.formats.media import open_media

if TYPE_CHECKING:
    from av import AudioFrame as Frame

__all__ = ["KEPT_RATE", "SHORTEST", "read_audio"]

KEPT_RATE = 48_000
"""Sound above this rate is brought down to it: nothing here needs more."""
SHORTEST = 0.02
"""Seconds; less than this is no sound that anything could speak."""
_TELEPHONE_RATE = 11_025
_BLOCK = 2**19  # samples, all channels together, decoded at a time
_LONG = 120  # seconds from which on 32 bits a sample are kept until the end, not 64: hours fit into memory
_OFFSET = 0.02  # of full scale; less is what converters add
_FULL = 1.0 - 2.0**-14
_CLIPPED = 0.002  # share of the samples
_LOUDEST = 2.0**33  # of full scale: whole numbers of 32 bits that are called floats are below it
_STRETCH = 0.05  # seconds over which channels are compared
_CANCELLED = 0.05  # share of a sound's power
_UNKNOWN_LENGTH = 0x7FFF0000  # bytes; 0, or this and more, is written by programs that did not know
_FEW_BYTES = 4096  # a header may be wrong by as much, or by 10 %, whichever is less
_FEWEST_BYTES_PER_SECOND = 75  # of any codec of speech; a header that promises less than this is wrong

Samples = NDArray[Any]


def read_audio(path: str | Path) -> tuple[Audio, tuple[Note, ...]]:
    """Read a sound file, or the sound track of a video.

    WAV, FLAC, OGG and AIFF are read by libsndfile; all else (MP3, M4A, MP4, MKV, MPG, ...) by FFmpeg's libraries.
    Several channels are averaged (where they would cancel, the loudest is taken), a constant offset is taken out,
    rates above `KEPT_RATE` are resampled; all are noted.

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
        If the file is missing, empty, cut short, holds no sound, or more than the limits ``hours`` and ``channels``.
    """
    path = Path(path)
    with reading(_existing(path), "a sound or video file"):
        return _read(path)


@dataclass
class _Sum:
    """What is known of a sound after it went by in blocks.

    Attributes
    ----------
    rate, channels, count : int
        ``count`` is of samples.
    power : ndarray, shape (channels,)
        Sums of squares, a constant offset apart.
    lost : float
        Power of the stretches in which the channels cancel in their average: less is left of them than unrelated
        sounds would leave. Summed over the channels.
    """

    rate: int
    channels: int
    count: int
    power: Samples
    lost: float = 0.0

    def take(self, block: Samples) -> None:
        """Take in one more block, shape (n, channels)."""
        self.count += len(block)
        size = min(len(block), max(1, round(_STRETCH * self.rate)))
        whole = len(block) // size * size
        for part in (block[:whole].reshape(-1, size, self.channels), block[None, whole:]):
            if not part.size:
                continue
            still = part - part.mean(axis=1, keepdims=True)
            power = np.square(still).sum(axis=1)
            left = np.square(still.mean(axis=2)).sum(axis=1)
            self.power += power.sum(axis=0)
            self.lost += float(power[left < 0.25 * power.mean(axis=1) / self.channels].sum())

    def cancels(self) -> bool:
        """Whether the channels cancel in their average, all the time or at times."""
        return self.channels > 1 and self.lost > _CANCELLED * float(self.power.sum())


def _read(path: Path) -> tuple[Audio, tuple[Note, ...]]:
    notes: list[Note] = []
    mono, about = _mixed(path, None, notes)
    rate = about.rate
    if about.cancels():
        loudest_channel = int(np.argmax(about.power))
        notes.append(
            Note(
                "warning",
                f"{path.name}: its {about.channels} channels cancel in their average (one is the other turned over): "
                f"channel {loudest_channel + 1} alone is used",
            )
        )
        mono, _ = _mixed(path, loudest_channel, [])
    elif about.channels > 1:
        notes.append(Note("note", f"{path.name} has {about.channels} channels: their average is used"))
    if len(mono) < SHORTEST * rate:
        raise InputError(f"{path}: expected at least {SHORTEST} s of sound, got {len(mono) / rate:.3f} s")
    mono = _within_scale(mono, path, notes)
    audio = Audio.taking(mono, rate) if mono.dtype == np.float32 else Audio(mono, rate)
    del mono
    if rate > KEPT_RATE:
        notes.append(Note("note", f"{path.name} is sampled at {rate} Hz: brought to {KEPT_RATE} Hz"))
        audio = audio.resampled(KEPT_RATE)
    elif rate <= _TELEPHONE_RATE:
        notes.append(Note("note", f"{path.name} is sampled at {rate} Hz: /s f th/ are hard to place in such sound"))
    return audio, tuple(notes)


def _within_scale(mono: Samples, path: Path, notes: list[Note]) -> Samples:
    """Without a constant offset, and no louder than full scale."""
    clipped = _clipped(mono)
    if clipped > _CLIPPED:
        notes.append(Note("warning", f"{path.name} is clipped ({clipped:.1%} of it cut flat): recorded too loud"))
    offset = sum(float(part.sum(dtype=np.float64)) for part in _parts(mono)) / len(mono)
    if abs(offset) > _OFFSET:
        notes.append(Note("note", f"{path.name} has a constant offset of {offset:+.2g} of full scale: taken out"))
        mono -= mono.dtype.type(offset)
    loudest = max(float(np.abs(part).max()) for part in _parts(mono))
    if loudest > 1.0:
        if clipped <= _CLIPPED:
            notes.append(Note("note", f"{path.name} peaks at {loudest:.3g} of full scale: turned down to fit"))
        mono /= mono.dtype.type(loudest)
    return mono


def _clipped(mono: Samples) -> float:
    """The share of samples that lie at the very top or bottom, three and more in a row."""
    ends = [(float(part.max()), float(part.min())) for part in _parts(mono)]
    count, top, bottom = 0, max(high for high, _ in ends), min(low for _, low in ends)
    for peak in (top, bottom) if top - bottom > _OFFSET else ():
        if abs(peak) <= _OFFSET:  # silence round an impulse is nothing cut flat
            continue
        for start in range(0, len(mono), _BLOCK):
            flat = np.abs(mono[start : start + _BLOCK] - peak) <= abs(peak) * (1.0 - _FULL)
            count += int((flat[:-2] & flat[1:-1] & flat[2:]).sum())
            let_go(mono)
    return count / len(mono)


def _parts(mono: Samples) -> Iterator[Samples]:
    """A sound piece by piece: a long one, which lies on the disk, is in memory a piece at a time."""
    for start in range(0, len(mono), _BLOCK):
        yield mono[start : start + _BLOCK]
        let_go(mono)


def _mixed(path: Path, channel: int | None, notes: list[Note]) -> tuple[Samples, _Sum]:
    """One channel, or the average of all, decoded block by block."""
    kept: Samples = np.zeros(0)
    done = 0
    about: _Sum | None = None
    for block, rate in _blocks(path, notes):
        if about is None:
            if not MIN_RATE <= rate <= MAX_RATE:
                raise InputError(f"{path}: expected a sample rate between {MIN_RATE} and {MAX_RATE} Hz, got {rate}")
            check_size("channels", block.shape[1], path)
            about = _Sum(rate, block.shape[1], 0, np.zeros(block.shape[1]))
        if not np.isfinite(block).all():
            bad = about.count + int(np.argmax(~np.isfinite(block).all(axis=1)))
            raise InputError(f"{path}: sample {bad} ({bad / rate:.3f} s) is not a finite number: is the file damaged?")
        if (loudest := float(np.abs(block).max(initial=0.0))) > _LOUDEST:
            raise InputError(f"{path}: a sample is {loudest:.2g} times full scale: is the file damaged?")
        about.take(block)
        check_size("hours", about.count / rate / 3600, path)
        one = block.mean(axis=1) if channel is None else block[:, channel]
        if about.count > _LONG * rate and kept.dtype == np.float64:
            kept = kept.astype(np.float32)
        if about.count > len(kept):  # twice the room, on the disk: nothing of an hour is held twice
            room = long_array(2 * about.count) if about.count > LONG * rate else np.empty(2 * about.count, kept.dtype)
            for start in range(0, done, _BLOCK):
                room[start : min(start + _BLOCK, done)] = kept[start : min(start + _BLOCK, done)]
                let_go(kept)
                let_go(room)
            kept = room
        kept[done : about.count] = one
        done = about.count
        let_go(kept)
    if about is None:
        raise InputError(f"{path}: expected at least {SHORTEST} s of sound, got none")
    return kept[:done], about


def _existing(path: Path) -> Path:
    if path.is_dir():
        raise InputError(f"{path}: expected a sound file, got a folder")
    if path.exists() and not path.is_file():
        raise InputError(f"{path}: expected a sound file, got a device or a pipe")
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
    check_begun(path)
    return path


def _blocks(path: Path, notes: list[Note]) -> Iterator[tuple[Samples, int]]:
    """Samples of shape (n, channels), some seconds at a time, and their rate."""
    import soundfile

    checked = _checked_wav(path, notes)
    if path.suffix.lower() == ".mp3" or _begins_as(path, b"ID3"):  # libsndfile's reader of those writes to the terminal
        yield from _blocks_of_ffmpeg(path, notes)
        return
    try:
        with soundfile.SoundFile(str(checked) if isinstance(checked, Path) else checked) as sound:
            if sound.format != "MP3":
                yield from _blocks_of_libsndfile(sound, path)
                return
    except soundfile.LibsndfileError as problem:
        if path.suffix.lower() in (".flac", ".ogg") and _begins_as(path, b"fLaC", b"OggS"):
            raise InputError(f"{path}: the file is damaged or cut short ({problem.error_string.strip()})") from problem
    yield from _blocks_of_ffmpeg(path, notes)


def _begins_as(path: Path, *marks: bytes) -> bool:
    with path.open("rb") as file:
        return file.read(4).startswith(marks)


def _blocks_of_libsndfile(sound: Any, path: Path) -> Iterator[tuple[Samples, int]]:
    expected, rate = sound.frames, int(sound.samplerate)
    known = expected < 2**40
    if known:
        check_size("hours", expected / max(1, rate) / 3600, path)
    check_size("channels", sound.channels, path)
    got = 0
    while len(block := sound.read(max(1, _BLOCK // sound.channels), dtype="float64", always_2d=True)):
        got += len(block)
        yield block, rate
    if known and got < expected - max(rate // 10, expected // 100):  # MP3 in WAV promises a few samples too many
        raise _cut_short(path, got / rate, expected / rate)


def _checked_wav(path: Path, notes: list[Note]) -> Path | io.BytesIO:
    """The file itself, or one with a header that holds, where its own does not.

    Raises
    ------
    InputError
        If a RIFF file promises more sound than it holds (libsndfile would read the rest in silence).
    """
    with path.open("rb") as file:
        head = file.read(12)
        if head[:4] != b"RIFF" or head[8:12] != b"WAVE":
            return path
        size, unpadded, form = path.stat().st_size, False, b""
        while len(chunk := file.read(8)) == 8:
            name, length = struct.unpack("<4sI", chunk)
            if name == b"data":
                held = size - file.tell()
                _refuse_cut(path, length, held, notes)
                if not form or not (unpadded or length == 0):
                    return path
                content = read_bytes(path)[file.tell() :]
                length = min(length or held, held)
                return io.BytesIO(_riff(form, content[:length]))
            content_at = file.tell()
            if name == b"fmt ":
                form = file.read(min(length, _FEW_BYTES))
            file.seek(content_at + length)
            if length % 2 and file.read(1) not in (b"", b"\0"):  # the byte that makes lengths even was left out
                unpadded = True
                file.seek(-1, 1)
    raise InputError(f"{path}: a WAV file without any sound in it: is it cut short?")


def _refuse_cut(path: Path, promised: int, held: int, notes: list[Note]) -> None:
    if promised <= held or promised == 0 or promised >= _UNKNOWN_LENGTH:
        return
    if held <= 0 or promised - held > max(min(_FEW_BYTES, held // 10), held // 100):
        raise InputError(
            f"{path}: the file is cut short: {promised} bytes of sound promised, {held} there; copy it again"
        )
    notes.append(Note("note", f"{path.name} promises {promised - held} bytes more than it holds"))


def _riff(form: bytes, content: bytes) -> bytes:
    """A WAV file of its format and its samples."""
    chunks = b"".join(
        name + struct.pack("<I", len(body)) + body + bytes(len(body) % 2)
        for name, body in ((b"fmt ", form), (b"data", content))
    )
    return b"RIFF" + struct.pack("<I", 4 + len(chunks)) + b"WAVE" + chunks


def _cut_short(path: Path, got: float, expected: float) -> InputError:
    return InputError(f"{path}: the file is cut short: {expected:.2f} s promised, {got:.2f} s there; copy it again")


def _blocks_of_ffmpeg(path: Path, notes: list[Note]) -> Iterator[tuple[Samples, int]]:
    import av

    got, rate = 0, 0
    with open_media(path) as container:
        if not container.streams.audio:
            raise InputError(f"{path}: expected sound, got a file without a sound track")
        if len(container.streams.audio) > 1:
            count = len(container.streams.audio)
            notes.append(Note("note", f"{path.name} has {count} sound tracks: the first is used"))
        stream = container.streams.audio[0]
        promised = _promised_seconds(stream, path.stat().st_size)
        check_size("hours", (promised or 0.0) / 3600, path)
        resampler = None
        try:
            for frame in _with_end(container.decode(stream)):
                if resampler is None:
                    if frame is None:
                        break
                    rate = frame.sample_rate
                    resampler = av.AudioResampler(format="dblp", layout=frame.layout, rate=rate)
                for out in resampler.resample(frame):
                    block = out.to_ndarray().T.astype(np.float64)
                    got += len(block)
                    yield block, rate
        except av.FFmpegError as problem:
            if not got:
                raise InputError(
                    f"{path}: expected a sound or video file, got nothing that can be decoded"
                ) from problem
            raise InputError(
                f"{path}: the sound breaks off after {got / rate:.2f} s: the file is damaged or cut short"
            ) from problem
    if promised and got / max(1, rate) < promised - 0.5:
        raise _cut_short(path, got / max(1, rate), promised)


def _with_end(frames: Iterable[Frame]) -> Iterator[Frame | None]:
    """The frames, then None, which makes a resampler give what it still holds."""
    yield from frames
    yield None


def _promised_seconds(stream: object, size: int) -> float | None:
    """How long a sound track says it is; None if it says nothing, or more than a file of so many bytes can hold."""
    duration, base = getattr(stream, "duration", None), getattr(stream, "time_base", None)
    seconds = float(duration * base) if duration and base else None
    return seconds if seconds and size > _FEWEST_BYTES_PER_SECOND * seconds else None
