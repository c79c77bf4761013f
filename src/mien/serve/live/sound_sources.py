"""Where live sound comes from: a microphone, standard input or a pipe, a file that may still grow."""

from __future__ import annotations

import os
import select
import stat
import sys
import threading
import time
from collections.abc import Callable, Iterator
from itertools import chain
from pathlib import Path
from typing import Any, Literal, Protocol

import numpy as np

from mien.core.errors import InputError, MissingPartError
from mien.formats.sound_files import read_audio
from mien.serve.live.sound_stream import Inbox, PcmDecoder, PcmForm, StreamedSound
from mien.speech.streaming_features import RATE

__all__ = ["MicrophoneSource", "Pace", "SampleSource", "SoundSource", "StreamSource", "microphones", "open_source"]

Pace = Literal["auto", "live", "stored"]
"""``live``: what is late is caught up with; ``stored``: everything is shown at its own pace; ``auto``: stored if it
comes much faster than it can have been spoken."""
_PIECE = 8192  # bytes read at once
_LOOK = 0.02  # seconds between looks at a file that may grow
_LOOKED_AT = 0.3  # seconds for which it is looked at how fast sound comes, before anything is shown
_BACKLOG = 1 << 17  # bytes that may have waited in pipes while this program started
_FASTER = 1.5  # seconds of sound beyond them in that time: more is no live source
_BLOCK = 0.01  # seconds of a block of the microphone


class SoundSource(Protocol):
    """Fills an `Inbox` from a thread of its own."""

    name: str
    stored: bool
    inbox: Inbox

    def start(self) -> None:
        """Begin."""

    def stop(self) -> None:
        """End; nothing is put into the inbox afterwards."""


class SampleSource:
    """Sound that is known already, shown at its own pace.

    Parameters
    ----------
    samples : ndarray
        16 kHz.
    """

    def __init__(self, samples: np.ndarray[Any, Any], name: str) -> None:
        self.name, self.stored = name, True
        self.inbox = Inbox(len(samples) / RATE + 1.0)
        self._samples = np.asarray(samples, dtype=np.float32)

    def start(self) -> None:
        """Give everything."""
        self.inbox.put(self._samples)
        self.inbox.end()

    def stop(self) -> None:
        """Nothing to do."""


class StreamSource:
    """Bytes from a file descriptor: standard input, a pipe, or a file that another program still writes.

    Parameters
    ----------
    opened : callable () -> int
        Gives the descriptor; called by the thread that reads, since opening a named pipe waits for its writer.
    raw : PcmForm
        Of samples without a WAV header.
    pace : Pace
    follow : bool
        Whether the end of what is there is not the end: it grows.
    """

    def __init__(
        self, opened: Callable[[], int], name: str, raw: PcmForm, pace: Pace = "auto", follow: bool = False
    ) -> None:
        self.name, self.stored, self.inbox = name, pace == "stored", Inbox()
        self._opened, self._sound, self._pace, self._follow = opened, StreamedSound(raw), pace, follow
        self._stopping, self._at_end = threading.Event(), False
        self._thread = threading.Thread(target=self._read, name="sound", daemon=True)

    def start(self) -> None:
        """Begin to read."""
        self._thread.start()

    def stop(self) -> None:
        """End; a thread that waits in the opening of a pipe is left behind, as a daemon."""
        self._stopping.set()
        self.inbox.end()
        self._thread.join(0.5)

    def _read(self) -> None:
        problem: BaseException | None = None
        try:
            self._read_from(self._opened())
            if self._sound.form is None and not self._stopping.is_set():
                problem = InputError(f"{self.name}: no sound came")
        except InputError as found:
            problem = InputError(f"{self.name}: {found}")
        except OSError as found:
            problem = InputError(f"{self.name} cannot be read: {found.strerror}")
        except Exception as found:  # a fault of ours: told where the frames are made, not lost with this thread
            problem = found
        self.inbox.end(problem)

    def _read_from(self, descriptor: int) -> None:
        first = self._at_first(descriptor) if self._pace == "auto" else []
        for data in chain(first, self._pieces(descriptor)):
            samples = self._sound.push(data)
            if not self.stored:
                self.inbox.put(samples)
            elif not self.inbox.put_when_room(samples):
                return

    def _pieces(self, descriptor: int, until: float | None = None) -> Iterator[bytes]:
        """Bytes as they come, to the end of the file or until an instant of `time.monotonic`."""
        while not self._stopping.is_set() and (until is None or time.monotonic() < until):
            if sys.platform != "win32" and not select.select([descriptor], [], [], 0.05)[0]:
                continue
            if data := os.read(descriptor, _PIECE):
                yield data
            elif self._follow:
                time.sleep(_LOOK)
            else:
                self._at_end = True
                return

    def _at_first(self, descriptor: int) -> list[bytes]:
        """The first bytes, and from how fast they come whether the sound is stored."""
        first = next(self._pieces(descriptor), None)
        if first is None:
            return []
        sound, seconds, size, found = StreamedSound(self._sound.raw), 0.0, 0, list[bytes]()
        for data in chain([first], self._pieces(descriptor, time.monotonic() + _LOOKED_AT)):
            found.append(data)
            seconds, size = seconds + len(sound.push(data)) / RATE, size + len(data)
            beyond = seconds * max(0, size - _BACKLOG) / size
            self.stored = beyond > _FASTER
            if self.stored:
                break
        self.stored |= self._at_end
        return found


class MicrophoneSource:
    """A microphone, through PortAudio.

    Parameters
    ----------
    device : str, int or None
        Part of its name or its number (`microphones`); None: the system's own choice.

    Raises
    ------
    MissingPartError
        If PortAudio or a microphone is missing.
    """

    def __init__(self, device: str | int | None = None) -> None:
        sounddevice = _sounddevice()
        try:
            facts = sounddevice.query_devices(device, "input")
        except (ValueError, sounddevice.PortAudioError) as problem:
            wanted = "no microphone was found" if device is None else f"there is no microphone {device!r}"
            raise MissingPartError(
                f"{wanted} ({problem}): see 'mien live --list-devices', or give sound otherwise: mien live FILE or '-'"
            ) from problem
        self.name, self.stored, self.inbox = str(facts["name"]), False, Inbox()
        self.overflows = 0
        rate = int(facts["default_samplerate"])
        self._decoder = PcmDecoder(PcmForm(rate, 1, "f32le"))
        self._stream: Any = None
        self._settings = {"samplerate": rate, "device": device, "channels": 1, "dtype": "float32"}

    def start(self) -> None:
        """Begin to listen."""
        sounddevice = _sounddevice()

        def hear(block: Any, frames: int, time: Any, status: Any) -> None:
            self.overflows += bool(status.input_overflow)
            self.inbox.put(self._decoder.resampled(block[:, 0].copy()))

        blocksize = round(self._decoder.form.rate * _BLOCK)
        try:
            self._stream = sounddevice.InputStream(
                callback=hear, blocksize=blocksize, latency="low", finished_callback=self.inbox.end, **self._settings
            )
            self._stream.start()
        except sounddevice.PortAudioError as problem:
            raise MissingPartError(f"the microphone {self.name!r} cannot be opened: {problem}") from problem

    def stop(self) -> None:
        """End."""
        if self._stream is not None:
            self._stream.close()


def _sounddevice() -> Any:
    try:
        import sounddevice
    except ImportError as problem:
        raise MissingPartError(
            "a microphone needs the package sounddevice: pip install 'mien[live]'; or give sound otherwise: "
            "mien live FILE, or '-' for standard input"
        ) from problem
    except OSError as problem:
        raise MissingPartError(
            "a microphone needs the library PortAudio (Debian, Ubuntu: apt install libportaudio2); or give sound "
            "otherwise: mien live FILE, or '-' for standard input"
        ) from problem
    return sounddevice


def microphones() -> list[str]:
    """All inputs with their numbers.

    Raises
    ------
    MissingPartError
        If PortAudio is missing.
    """
    found = _sounddevice().query_devices()
    return [f"{number}: {device['name']}" for number, device in enumerate(found) if device["max_input_channels"] > 0]


def _is_stored(descriptor: int) -> bool:
    """Whether a descriptor is that of a file, as in ``mien live - < sound.wav``."""
    try:
        return stat.S_ISREG(os.fstat(descriptor).st_mode)
    except OSError:
        return False


def open_source(place: str, raw: PcmForm, pace: Pace = "auto", follow: bool = False) -> SoundSource:
    """The sound of standard input (``-``), of a pipe, or of a file.

    Raises
    ------
    InputError
        If there is no such file, or it is none that can be read.
    """
    if place == "-":
        if pace == "auto" and not follow and _is_stored(0):
            pace = "stored"
        return StreamSource(lambda: 0, "standard input", raw, pace, follow)
    path = Path(place)
    try:
        mode = path.stat().st_mode
    except OSError as problem:
        raise InputError(f"{place}: no such file or pipe") from problem
    if stat.S_ISDIR(mode):
        raise InputError(f"{place}: expected a sound file or a pipe, got a folder")
    if stat.S_ISREG(mode) and not follow and not _is_raw(path):
        audio, _ = read_audio(path)
        return SampleSource(audio.resampled(RATE).samples, path.name)
    if stat.S_ISREG(mode) and pace == "auto":
        pace = "live" if follow else "stored"
    return StreamSource(lambda: os.open(path, os.O_RDONLY), place, raw, pace, follow)


def _is_raw(path: Path) -> bool:
    return path.suffix.lower() in (".raw", ".pcm", ".s16", ".f32")
