"""``.mp4``: the performance as a video, H.264 with AAC sound.

The picture is drawn in the calling thread while a second one encodes. Frame ``i`` is shown from ``i / fps``; the sound
starts with frame 0 (the encoder's delay is written into the file, players and decoders take it off). The same input
gives the same picture stream: the encoder runs with a fixed number of threads.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path
from queue import Queue
from threading import Event, Thread
from typing import Any, Protocol

import av
import numpy as np
from numpy.typing import NDArray

from mien.animation.animation import Animation
from mien.core.audio import Audio
from mien.core.errors import InputError, Note, OutputError
from mien.core.files import replace_when_complete
from mien.face.deformers import poser_for
from mien.face.model import Face
from mien.face.posing import PosedFace
from mien.face.render.renderer import Renderer

__all__ = ["Pictures", "write_frames", "write_video"]

Picture = NDArray[np.uint8]


class Pictures(Protocol):
    """What draws a posed face."""

    def render(self, posed: PosedFace) -> Picture:
        """Draw one."""
        ...


# Constant quality (lower is better), speed of the encoder, and seconds between frames that one can jump to.
_QUALITY, _PRESET, _SECONDS_PER_KEY = "18", "veryfast", 2
_AAC_RATES = (96000, 88200, 64000, 48000, 44100, 32000, 24000, 22050, 16000, 12000, 11025, 8000)
_SOUND_BITS_PER_SECOND = 128_000
_WAITING = 4  # pictures drawn ahead of the encoder


def write_video(
    animation: Animation,
    face: Face,
    path: str | Path,
    *,
    width: int = 1280,
    height: int = 720,
    progress: Callable[[int, int], None] | None = None,
    renderer: Pictures | None = None,
) -> tuple[Note, ...]:
    """Render an animation into an MP4 file with its sound.

    Parameters
    ----------
    animation : Animation
    face : Face
    path : path-like
        Ends in ``.mp4``. Replaced if it exists; never left half-written.
    width, height : int
        Pixels, both even.
    progress : callable, optional
        Called with (frames done, frames in all).
    renderer : Renderer or what renders like one, optional
        Of this face, ``width`` and ``height``; the portrait otherwise.

    Returns
    -------
    tuple of Note
        What was done with an odd sample rate.

    Raises
    ------
    InputError
        If the animation has no frames, or a side is odd or out of range.
    OutputError
        If the file cannot be written.
    """
    track = animation.channels
    if len(track) == 0:
        raise InputError(f"cannot write {path}: the animation has no frames")
    _check_size(width, height)
    poser, renderer = poser_for(face, track.names), renderer or Renderer(face, width, height)

    def pictures() -> Iterator[Picture]:
        for number, row in enumerate(track.values):
            yield renderer.render(poser.pose(row))
            if progress is not None:
                progress(number + 1, len(track))

    return write_frames(pictures(), animation.rate.fraction, animation.utterance.audio, path, (width, height))


def write_frames(
    pictures: Iterator[Picture], fps: Fraction, sound: Audio, path: str | Path, size: tuple[int, int]
) -> tuple[Note, ...]:
    """Write pictures and a sound that start together as an MP4 file.

    Parameters
    ----------
    pictures : iterator of ndarray of uint8, shape (height, width, 3)
        sRGB.
    fps : Fraction
        Pictures per second.
    sound : Audio
        May be empty; then the file has no sound track.
    path : path-like
        Ends in ``.mp4``.
    size : tuple of 2 int
        Width and height of the pictures, both even.

    Raises
    ------
    InputError
        If a side is odd.
    OutputError
        If the suffix is not ``.mp4``, or the file cannot be written.
    """
    _check_size(*size)
    if Path(path).suffix.lower() != ".mp4":
        raise OutputError(f"a video is written as .mp4, not {Path(path).suffix!r}: {path}")
    sound, notes = _encodable(sound)
    with replace_when_complete(path) as unfinished:
        try:
            with av.open(str(unfinished), "w", format="mp4", options={"movflags": "+faststart"}) as container:
                video = _video_stream(container, fps, size)
                voice = _sound_stream(container, sound.rate) if len(sound) else None
                _encode(container, video, voice, pictures, fps, sound)
        except av.FFmpegError as problem:
            raise OSError(problem.errno, problem.strerror) from problem
    return notes


def _check_size(width: int, height: int) -> None:
    if width % 2 or height % 2:
        even = f"{width + width % 2} x {height + height % 2}"
        raise InputError(f"a video's sides are even numbers of pixels, not {width} x {height}; {even} would do")


def _encodable(sound: Audio) -> tuple[Audio, tuple[Note, ...]]:
    """The sound at a rate that AAC has."""
    if sound.rate in _AAC_RATES:
        return sound, ()
    rate = 44100 if 44100 % sound.rate == 0 else 48000
    message = f"AAC has no sample rate of {sound.rate} Hz; the video's sound has {rate} Hz"
    return sound.resampled(rate), (Note("note", message),)


def _video_stream(container: Any, fps: Fraction, size: tuple[int, int]) -> Any:
    stream = container.add_stream("libx264", rate=fps)
    stream.width, stream.height = size
    stream.pix_fmt = "yuv420p"
    context = stream.codec_context
    context.color_range = 1  # 16..235
    context.color_primaries = context.color_trc = context.colorspace = 1  # BT.709
    context.gop_size = max(1, round(fps * _SECONDS_PER_KEY))
    # Without mbtree: on processors with AVX it reads memory that was never written, so that small pictures came out in
    # other bytes now and then (eleven variants in 200 runs of one input; without it one).
    stream.options = {"crf": _QUALITY, "preset": _PRESET, "threads": "1", "x264-params": "mbtree=0"}
    return stream


def _sound_stream(container: Any, rate: int) -> Any:
    stream = container.add_stream("aac", rate=rate, layout="mono")
    stream.bit_rate = min(_SOUND_BITS_PER_SECOND, 5 * rate)
    return stream


def _encode(
    container: Any, video: Any, voice: Any | None, pictures: Iterator[Picture], fps: Fraction, sound: Audio
) -> None:
    """Feed the encoders from a second thread while this one draws."""
    queue: Queue[tuple[int, Picture] | None] = Queue(maxsize=_WAITING)
    failures: list[BaseException] = []
    ended = Event()

    def fed() -> Iterator[tuple[int, Picture]]:
        while (item := queue.get()) is not None:
            yield item
        ended.set()

    def work() -> None:
        try:
            _encode_pictures(container, video, voice, fed(), fps, sound)
        except BaseException as problem:  # handed to the caller's thread, which raises it
            failures.append(problem)
            while not ended.is_set() and queue.get() is not None:  # a fault of the last flush has nothing to wait for
                pass

    worker = Thread(target=work, name="mien-video-encoder")
    worker.start()
    try:
        for number, picture in enumerate(pictures):
            if failures:
                break
            queue.put((number, picture))
    finally:
        queue.put(None)
        worker.join()
    if failures:
        raise failures[0]


def _encode_pictures(
    container: Any, video: Any, voice: Any | None, fed: Iterator[tuple[int, Picture]], fps: Fraction, sound: Audio
) -> None:
    """Encode pictures as they come, each followed by the sound up to its end, so that the tracks lie side by side."""
    blocks = _SoundBlocks(container, voice, sound)
    for number, picture in fed:
        frame = av.VideoFrame.from_ndarray(picture, format="rgb24").reformat(
            format="yuv420p",
            src_colorspace="ITU709",
            dst_colorspace="ITU709",
            src_color_range="JPEG",
            dst_color_range="MPEG",
            threads=1,
        )
        frame.pts, frame.time_base = number, 1 / fps
        container.mux(video.encode(frame))
        blocks.write_until(round((number + 1) / fps * sound.rate))
    container.mux(video.encode(None))
    blocks.write_until(len(sound))
    if voice is not None:
        container.mux(voice.encode(None))


class _SoundBlocks:
    """Feeds a sound to its encoder in the blocks of 1024 samples that AAC takes."""

    def __init__(self, container: Any, stream: Any | None, sound: Audio) -> None:
        self.container, self.stream, self.sound = container, stream, sound
        self.done = 0

    def write_until(self, sample: int) -> None:
        """Encode whole blocks up to ``sample``; at the end of the sound also the last, shorter one."""
        if self.stream is None:
            return
        end = min(sample, len(self.sound))
        while self.done < end and (self.done + 1024 <= end or end == len(self.sound)):
            piece = self.sound.samples[self.done : min(self.done + 1024, end)]
            block = av.AudioFrame.from_ndarray(np.ascontiguousarray(piece[None]), format="fltp", layout="mono")
            block.sample_rate, block.pts, block.time_base = self.sound.rate, self.done, Fraction(1, self.sound.rate)
            self.container.mux(self.stream.encode(block))
            self.done += len(piece)
