"""Microphone and camera: `Devices` records both at once, on one clock.

The sound is cut to start with the first picture, so that both files of a take begin at the same instant. Pictures carry
the times at which they arrived (`steady_frames` of the video reader makes the rate steady later). What a camera and a
microphone delay by their own buffers is not known here; ``mien corpus check`` tells the lag that is left.
"""

from __future__ import annotations

import errno
import sys
import threading
import time
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from mien.core.audio import Audio
from mien.core.errors import InputError, MissingPartError, Note, OutputError
from mien.corpus.recording.folder import writing
from mien.corpus.recording.scripts import Line

__all__ = ["Camera", "CameraDevice", "Devices", "Microphone", "MicrophoneDevice", "open_devices"]

RATE = 48_000
_TICK = Fraction(1, 90_000)  # seconds; the clock of the pictures in the file
_ENCODING = {"crf": "16", "preset": "ultrafast"}  # near the camera's own quality, and light enough to keep up
_JOIN = 10.0  # seconds to wait for the last picture


class Microphone(Protocol):
    """Gives sound between `start` and `stop`."""

    def start(self) -> None:
        """Begin."""
        ...

    def stop(self) -> tuple[float, Audio]:
        """End; the instant (`time.monotonic`) of the first sample, and the sound."""
        ...


class Camera(Protocol):
    """Writes a video between `start` and `stop`."""

    def start(self, path: Path) -> None:
        """Begin to write."""
        ...

    def stop(self) -> float:
        """End; the instant (`time.monotonic`) of the first picture."""
        ...


class Devices:
    """A microphone, and a camera if there is one, as a source of takes."""

    live = True

    def __init__(self, microphone: Microphone, camera: Camera | None) -> None:
        self._microphone, self._camera = microphone, camera

    def take(self, line: Line, name: str, folder: Path, until_done: Callable[[], None]) -> list[Path]:
        """Record until the speaker has finished; both devices stop whatever happens."""
        files = [folder / f"{name}.wav"]
        first_picture: float | None = None
        if self._camera is not None:
            files.append(folder / f"{name}.mp4")
            self._camera.start(files[1])
        try:
            self._microphone.start()
            try:
                until_done()
            finally:
                began, audio = self._microphone.stop()
        finally:
            if self._camera is not None:
                first_picture = self._camera.stop()
        _write_sound(_from(audio, 0.0 if first_picture is None else first_picture - began), files[0])
        return files


def _write_sound(audio: Audio, path: Path) -> None:
    import soundfile

    try:
        with writing(path):
            audio.write(path)
    except soundfile.LibsndfileError as problem:
        raise OutputError(f"cannot write {path}: {problem.error_string.strip()} Is the disk full?") from problem


def _from(audio: Audio, seconds: float) -> Audio:
    """The sound from an instant on; if that lies before it, silence first.

    >>> [len(_from(Audio.silence(1.0, 8000), seconds)) for seconds in (0.25, -0.25)]
    [6000, 10000]
    """
    if seconds <= 0:
        return Audio.join([Audio.silence(-seconds, audio.rate), audio])
    return Audio(audio.samples[round(seconds * audio.rate) :], audio.rate)


def open_devices(camera: str | None, wants_camera: bool = True) -> tuple[Devices, tuple[Note, ...]]:
    """Open what there is.

    Parameters
    ----------
    camera : str or None
        Such as ``/dev/video0`` (Linux), ``0`` (macOS), ``video=Integrated Camera`` (Windows); None takes the first, if
        there is one.
    wants_camera : bool
        False: sound only.

    Raises
    ------
    MissingPartError
        If there is no microphone, or not the camera that was asked for.
    """
    microphone = MicrophoneDevice()
    if not wants_camera:
        return Devices(microphone, None), ()
    found = camera or _first_camera()
    if found is None:
        note = Note("warning", "no camera found: only the sound is recorded; motion has to come from somewhere else")
        return Devices(microphone, None), (note,)
    device = CameraDevice(found)
    device.check()
    return Devices(microphone, device), ()


def _camera_format() -> str:
    """FFmpeg's name for the cameras of this system."""
    return {"darwin": "avfoundation", "win32": "dshow"}.get(sys.platform, "v4l2")


def _first_camera() -> str | None:
    """The first camera, as FFmpeg wants it named here."""
    import av

    kind = _camera_format()
    if kind == "v4l2":
        return next((str(path) for path in sorted(Path("/dev").glob("video*"))), None)
    try:
        cameras = av.enumerate_input_devices(kind)
    except (ValueError, av.FFmpegError):  # FFmpeg was built without them
        return None
    names = [one.name for one in cameras if "video" in (getattr(one, "media_types", None) or ["video"])]
    return next((f"video={name}" if kind == "dshow" else name for name in names), None)


class MicrophoneDevice:
    """The default microphone, through PortAudio.

    Raises
    ------
    MissingPartError
        If PortAudio or a microphone is missing.
    """

    def __init__(self) -> None:
        hint = "or record otherwise and give the files with --from FOLDER"
        try:
            import sounddevice
        except ImportError as problem:
            raise MissingPartError(
                f"recording needs the package sounddevice: pip install sounddevice, {hint}"
            ) from problem
        except OSError as problem:
            raise MissingPartError(
                f"recording needs PortAudio (Debian, Ubuntu: apt install libportaudio2), {hint}"
            ) from problem
        try:
            sounddevice.check_input_settings(samplerate=RATE, channels=1)
        except (sounddevice.PortAudioError, ValueError) as problem:
            raise MissingPartError(
                f"no microphone that records at {RATE} Hz ({problem}): plug one in, {hint}"
            ) from problem
        self._library: Any = sounddevice
        self._stream: Any = None
        self._blocks: list[NDArray[np.float32]] = []
        self._began = 0.0

    def start(self) -> None:
        """Begin."""
        self._blocks = []
        try:
            self._stream = self._library.InputStream(samplerate=RATE, channels=1, callback=self._heard)
            self._stream.start()
        except self._library.PortAudioError as problem:
            raise InputError(f"the microphone cannot be used ({problem}): does another program hold it?") from problem

    def _heard(self, block: NDArray[np.float32], frames: int, _time: object, _status: object) -> None:
        if not self._blocks:
            self._began = time.monotonic() - frames / RATE
        self._blocks.append(block[:, 0].copy())

    def stop(self) -> tuple[float, Audio]:
        """End."""
        self._stream.stop()
        self._stream.close()
        if not self._blocks:
            raise InputError("the microphone gave no sound: is it muted, or unplugged?")
        return self._began, Audio(np.concatenate(self._blocks), RATE)


class CameraDevice:
    """A camera of Video4Linux, AVFoundation or DirectShow, written as H.264.

    Parameters
    ----------
    device : str
    format : str or None
        Of FFmpeg's inputs; "" is that of this system's cameras, and None lets a test play a file.
    """

    def __init__(self, device: str, format: str | None = "") -> None:
        self._device, self._format = device, _camera_format() if format == "" else format
        self._thread: threading.Thread | None = None
        self._stopping = threading.Event()
        self._first: float | None = None
        self._problem: Exception | None = None

    def check(self) -> None:
        """Open it once.

        Raises
        ------
        MissingPartError
            If it is not there, or held by another program.
        """
        self._opened().close()

    def _opened(self) -> Any:
        import av

        try:
            source = av.open(self._device, format=self._format)
        except (av.FFmpegError, ValueError) as problem:
            raise MissingPartError(
                f"the camera {self._device} cannot be opened ({problem}): name another with --camera, or --no-camera"
            ) from problem
        if not source.streams.video:
            source.close()
            raise MissingPartError(f"{self._device} gives no pictures: name a camera with --camera, or --no-camera")
        return source

    def start(self, path: Path) -> None:
        """Begin to write."""
        self._stopping.clear()
        self._first, self._problem = None, None
        self._thread = threading.Thread(target=self._write, args=(path, self._opened()), daemon=True)
        self._thread.start()

    def stop(self) -> float:
        """End."""
        self._stopping.set()
        if self._thread is not None:
            self._thread.join(_JOIN)
            if self._thread.is_alive():
                raise InputError(f"the camera {self._device} gives no more pictures: is it unplugged?")
        if self._problem is not None:
            if getattr(self._problem, "errno", None) == errno.ENOSPC:
                raise OutputError("cannot write the pictures: the disk is full; free some space and run again")
            raise InputError(
                f"the camera {self._device} broke off ({self._problem}): is it unplugged?"
            ) from self._problem
        if self._first is None:
            raise InputError(f"the camera {self._device} gave no picture: is it covered, or held by another program?")
        return self._first

    def _write(self, path: Path, source: Any) -> None:
        import av

        try:
            with source, av.open(str(path), "w") as target:
                stream: Any = None
                for frame in source.decode(video=0):
                    now = time.monotonic()
                    if stream is None:
                        self._first = now
                        rate = source.streams.video[0].average_rate or 30
                        stream = target.add_stream("libx264", rate=rate, options=_ENCODING)
                        stream.width, stream.height = frame.width // 2 * 2, frame.height // 2 * 2
                        stream.pix_fmt, stream.codec_context.time_base = "yuv420p", _TICK
                    picture = frame.reformat(stream.width, stream.height, "yuv420p")
                    picture.pts, picture.time_base = round((now - (self._first or now)) / _TICK), _TICK
                    target.mux(stream.encode(picture))
                    if self._stopping.is_set():
                        break
                if stream is not None:
                    target.mux(stream.encode())
        except (av.FFmpegError, OSError, ValueError) as problem:
            self._problem = problem  # told by `stop`, in the thread of the session
