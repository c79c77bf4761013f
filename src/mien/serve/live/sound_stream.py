"""Sound as it arrives, whatever rate and form it has, as 16 kHz in -1..1."""

from __future__ import annotations

import struct
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.core.audio import MAX_RATE, MIN_RATE
from mien.core.errors import InputError, unknown_name
from mien.serve.live.resampling import StreamResampler
from mien.speech.streaming_features import RATE

__all__ = ["FORMATS", "Inbox", "PcmDecoder", "PcmForm", "StreamedSound", "read_form"]

Single = NDArray[np.float32]

FORMATS = {
    "u8": ("u1", 1), "s16le": ("<i2", 2), "s24le": ("", 3), "s32le": ("<i4", 4),
    "f32le": ("<f4", 4), "f64le": ("<f8", 8),
}  # fmt: skip
"""Names of sample forms, as FFmpeg has them, with numpy's name and the bytes of a sample."""
_MAGIC = {b"ID3": "MP3", b"OggS": "Ogg", b"fLaC": "FLAC", b"\xff\xfb": "MP3", b"\xff\xf3": "MP3", b"FORM": "AIFF",
          b"\x1aE\xdf\xa3": "Matroska", b"caff": "CAF"}  # fmt: skip
_LARGEST_HEADER = 1 << 16


@dataclass(frozen=True)
class PcmForm:
    """How samples lie in bytes.

    Attributes
    ----------
    rate : int
        Samples per second of each channel.
    channels : int
        Interleaved; they are averaged.
    format : str
        One of `FORMATS`.

    Raises
    ------
    InputError
        If one of them is out of range.
    """

    rate: int = RATE
    channels: int = 1
    format: str = "s16le"

    def __post_init__(self) -> None:
        if self.format not in FORMATS:
            raise unknown_name("form of samples", self.format, FORMATS)
        if not MIN_RATE <= self.rate <= MAX_RATE:
            raise InputError(f"a sample rate lies between {MIN_RATE} and {MAX_RATE} Hz, not {self.rate}")
        if not 1 <= self.channels <= 64:
            raise InputError(f"sound has 1 to 64 channels, not {self.channels}")

    @property
    def frame_bytes(self) -> int:
        """Bytes of one sample of every channel."""
        return FORMATS[self.format][1] * self.channels


class PcmDecoder:
    """Bytes in pieces of any length to samples at 16 kHz.

    Examples
    --------
    >>> decoder = PcmDecoder(PcmForm(16000, 2))
    >>> decoder.push(struct.pack("<3h", 16384, 0, 8192)).tolist(), decoder.push(struct.pack("<h", 0)).tolist()
    ([0.25], [0.125])
    """

    def __init__(self, form: PcmForm) -> None:
        self.form = form
        self._rest = b""
        self._resampler = StreamResampler(form.rate, RATE) if form.rate != RATE else None

    def push(self, data: bytes) -> Single:
        """Samples at 16 kHz; a sample cut in two waits for its other half. Numbers that are not finite count as 0."""
        data = self._rest + data
        whole = len(data) // self.form.frame_bytes * self.form.frame_bytes
        self._rest = data[whole:]
        return self.resampled(_samples(data[:whole], self.form.format).reshape(-1, self.form.channels).mean(axis=1))

    def resampled(self, samples: NDArray[np.floating]) -> Single:
        """One channel at the form's rate to 16 kHz."""
        clean = np.nan_to_num(np.asarray(samples, dtype=np.float32), nan=0.0, posinf=1.0, neginf=-1.0)
        clean = np.clip(clean, -1.0, 1.0)
        if self._resampler is None or not len(clean):
            return clean
        return self._resampler.push(clean).astype(np.float32)


def _samples(data: bytes, form: str) -> NDArray[np.floating]:
    if form == "u8":
        return (np.frombuffer(data, np.uint8).astype(np.float32) - 128) / 128
    if form == "s24le":
        parts = np.frombuffer(data, np.uint8).reshape(-1, 3).astype(np.int32)
        whole = (parts[:, 0] << 8 | parts[:, 1] << 16 | parts[:, 2] << 24) >> 8
        return np.asarray(whole.astype(np.float32) / 2**23)
    numbers = np.frombuffer(data, FORMATS[form][0])
    if form.startswith("f"):
        return numbers.astype(np.float32)
    return np.asarray(numbers.astype(np.float64) / 2 ** (8 * FORMATS[form][1] - 1))


def read_form(head: bytes) -> tuple[PcmForm, int] | None:
    """The form that the header of a WAV file tells and where its samples begin; None: more of the head is needed.

    Lengths in the header are not believed: a stream is written before its length is known.

    Raises
    ------
    InputError
        If it is a WAV file of another form than plain samples, or damaged.
    """
    if len(head) < 12:
        return None
    if head[8:12] != b"WAVE":
        raise InputError("expected WAVE after the head of a RIFF stream: it is not a sound, or it is damaged")
    place, form = 12, None
    while place + 8 <= len(head):
        name, size = head[place : place + 4], int.from_bytes(head[place + 4 : place + 8], "little")
        if name == b"data":
            if form is None:
                raise InputError("the WAV stream has no 'fmt ' part before its samples: it is damaged")
            return form, place + 8
        if name == b"fmt " and place + 8 + min(size, 40) <= len(head):
            form = _wav_form(head[place + 8 : place + 8 + size])
        place += 8 + size + size % 2
        if place > _LARGEST_HEADER:
            raise InputError("the WAV stream has no samples in its first 64 kB: it is damaged")
    return None


def _wav_form(part: bytes) -> PcmForm:
    if len(part) < 16:
        raise InputError("the 'fmt ' part of the WAV stream is too short: it is damaged")
    kind, channels, rate, _, _, bits = struct.unpack_from("<HHIIHH", part)
    if kind == 0xFFFE and len(part) >= 26:
        kind = int.from_bytes(part[24:26], "little")
    names = {(1, 8): "u8", (1, 16): "s16le", (1, 24): "s24le", (1, 32): "s32le", (3, 32): "f32le", (3, 64): "f64le"}
    if (kind, bits) not in names:
        raise InputError(f"the WAV stream has samples of kind {kind} with {bits} bits; expected plain PCM or float")
    return PcmForm(rate, channels, names[kind, bits])


class StreamedSound:
    """Bytes of a WAV stream or of raw samples, whichever comes, to samples at 16 kHz.

    Parameters
    ----------
    raw : PcmForm
        The form of the samples where no WAV header comes first.
    """

    def __init__(self, raw: PcmForm) -> None:
        self.raw, self._head = raw, b""
        self._decoder: PcmDecoder | None = None

    @property
    def form(self) -> PcmForm | None:
        """Known once the first bytes have come."""
        return self._decoder.form if self._decoder else None

    def push(self, data: bytes) -> Single:
        """Samples at 16 kHz.

        Raises
        ------
        InputError
            If the first bytes are those of a compressed file, or the WAV header cannot be used.
        """
        if self._decoder is not None:
            return self._decoder.push(data)
        self._head += data
        if len(self._head) < 4:
            return np.zeros(0, np.float32)
        start = 0
        if self._head[:4] in (b"RIFF", b"RF64"):
            if (found := read_form(self._head)) is None:
                return np.zeros(0, np.float32)
            form, start = found
        else:
            self._refuse_compressed()
            form = self.raw
        self._decoder = PcmDecoder(form)
        return self._decoder.push(self._head[start:])

    def _refuse_compressed(self) -> None:
        kind = next((kind for magic, kind in _MAGIC.items() if self._head.startswith(magic)), None)
        if kind is None and self._head[4:8] == b"ftyp":
            kind = "MP4"
        if kind is not None:
            raise InputError(
                f"the stream begins like {kind}: expected WAV or raw samples; decode it first: "
                "ffmpeg -i IN -f wav - | mien live -"
            )


class Inbox:
    """Samples on their way from a thread that reads to the frames, never more than a bounded number.

    Parameters
    ----------
    seconds : float
        What it holds at most.

    Attributes
    ----------
    dropped : int
        Samples that came while it was full (the oldest ones are lost).
    tap : callable or None
        Gets everything that comes, in the thread that reads, whatever becomes of it.
    """

    def __init__(self, seconds: float = 4.0) -> None:
        self._room = round(seconds * RATE)
        self._pieces: deque[Single] = deque()
        self._held = 0
        self._lock = threading.Condition()
        self._ended = False
        self._problem: BaseException | None = None
        self.dropped = 0
        self.arrived = 0
        self.tap: Callable[[Single], None] | None = None

    def __len__(self) -> int:
        return self._held

    def put(self, samples: Single) -> None:
        """Add samples; in a full box the oldest are lost."""
        with self._lock:
            self._add(samples)
            while self._held > self._room:
                lost = min(len(self._pieces[0]), self._held - self._room)
                self._pieces[0] = self._pieces[0][lost:]
                if not len(self._pieces[0]):
                    self._pieces.popleft()
                self._held, self.dropped = self._held - lost, self.dropped + lost

    def put_when_room(self, samples: Single) -> bool:
        """Add samples when the box is at most half full; waits until then. False: nobody takes them any more."""
        with self._lock:
            self._lock.wait_for(lambda: self._held <= self._room // 2 or self._ended)
            if self._ended:
                return False
            self._add(samples)
            return True

    def _add(self, samples: Single) -> None:
        if len(samples):
            self._pieces.append(samples)
            self._held += len(samples)
            self.arrived += len(samples)
            if self.tap is not None:
                self.tap(samples)

    def take(self, most: int | None = None) -> Single:
        """What has come, at most so many samples.

        Raises
        ------
        Exception
            What the thread that reads met with, once everything before it was taken.
        """
        with self._lock:
            joined = np.concatenate(self._pieces) if self._pieces else np.zeros(0, np.float32)
            taken, rest = (joined, joined[:0]) if most is None else (joined[:most], joined[most:])
            self._pieces = deque([rest] if len(rest) else [])
            self._held = len(rest)
            self._lock.notify_all()
            if self._problem is not None and not len(joined):
                problem, self._problem = self._problem, None
                raise problem
            return taken

    def end(self, problem: BaseException | None = None) -> None:
        """Say that nothing will come any more, and why."""
        with self._lock:
            self._ended, self._problem = True, problem
            self._lock.notify_all()

    @property
    def over(self) -> bool:
        """Whether nothing will come and nothing is left."""
        with self._lock:
            return self._ended and not self._held and self._problem is None
