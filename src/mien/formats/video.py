"""``.mp4``, ``.webm``, ``.mov``: the performance as a video with its sound.

H.264 with AAC, VP9 with Opus, ProRes with PCM; the last two can be transparent. The picture is drawn in the calling
thread while a second one encodes. Frame ``i`` is shown from ``i / fps``; the sound starts with frame 0 (the encoder's
delay is written into the file, players and decoders take it off). The same input gives the same picture stream: the
encoders run with a fixed number of threads.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from queue import Queue
from threading import Event, Thread
from typing import Any

import av
import numpy as np
from numpy.typing import NDArray

from mien.animation.animation import Animation
from mien.core.audio import Audio
from mien.core.compiled import njit
from mien.core.errors import InputError, MissingPartError, Note, OutputError
from mien.core.files import replace_when_complete
from mien.face.model import Face
from mien.face.render.renderer import Picture
from mien.face.render.view import TRANSPARENT, Pictures, View
from mien.formats.drawn_frames import drawn_frames

__all__ = ["FILMS", "Film", "check_film", "luma_and_chroma", "write_frames", "write_video"]

_SECONDS_PER_KEY = 2  # a key picture so often, so that players can jump
_SOUND_BITS_PER_SECOND = 128_000
_WAITING = 4  # pictures drawn ahead of the encoder
_BLOCK = 1024  # samples given to the sound's encoder at once, where it takes any number
_LOUDEST = 10 ** (-1.5 / 20)  # of full scale, of compressed sound: decoders overshoot by up to 1.1 dB
_RATE = 48000  # of compressed sound: what every player takes


@dataclass(frozen=True)
class Film:
    """A kind of video file.

    Attributes
    ----------
    container : str
        As FFmpeg calls it.
    codec, clear_codec : str
        Encoder of opaque and of transparent pictures; the latter is empty where there is none.
    pixels, clear_pixels : str
        How they are kept.
    options : callable
        Of the encoder, for a quality of `mien.face.render.view.QUALITIES`.
    voice : str
        Encoder of the sound.
    rates : tuple of int
        Sample rates it has; empty: all.
    even : tuple of 2 int
        Of what the width and the height are multiples.
    """

    container: str
    codec: str
    clear_codec: str
    pixels: str
    clear_pixels: str
    options: Callable[[str], dict[str, str]]
    voice: str
    rates: tuple[int, ...]
    even: tuple[int, int]


def _h264(quality: str) -> dict[str, str]:
    # Without B-frames: players that pass over edit lists would show everything a frame or two late.
    # Without mbtree: on processors with AVX it reads memory that was never written, so that small pictures came out in
    # other bytes now and then (eleven variants in 200 runs of one input; without it one).
    # Full: nearer to what was drawn than "veryfast", in three fifths of its time; files are 15 % larger.
    crf, preset, more = {
        "draft": ("26", "superfast", ""),
        "full": ("18", "superfast", ":aq-mode=0"),
        "best": ("13", "medium", ""),
    }[quality]
    return {"crf": crf, "preset": preset, "threads": "1", "x264-params": f"mbtree=0:bframes=0{more}"}


def _vp9(quality: str) -> dict[str, str]:
    crf, speed = {"draft": ("40", "8"), "full": ("26", "6"), "best": ("18", "3")}[quality]
    # auto-alt-ref goes with no transparency.
    return {"crf": crf, "b": "0", "deadline": "good", "cpu-used": speed, "threads": "1", "auto-alt-ref": "0"}


def _prores(quality: str) -> dict[str, str]:
    return {
        "quant_mat": "auto",
        "vendor": "apl0",
        "bits_per_mb": {"draft": "600", "full": "2000", "best": "4000"}[quality],
    }


FILMS: dict[str, Film] = {
    ".mp4": Film("mp4", "libx264", "", "yuv420p", "", _h264, "aac", (_RATE,), (2, 2)),
    ".webm": Film("webm", "libvpx-vp9", "libvpx-vp9", "yuv420p", "yuva420p", _vp9, "libopus", (_RATE,), (2, 2)),
    ".mov": Film("mov", "prores_ks", "prores_ks", "yuv422p10le", "yuva444p10le", _prores, "pcm_s24le", (), (2, 1)),
}
"""Kinds of video by their suffix."""


def check_film(path: str | Path, view: View) -> None:
    """Refuse what a kind of video cannot hold.

    Raises
    ------
    InputError
        If it has no transparency and the pictures have, or a side is odd.
    OutputError
        If the suffix is not one of `FILMS`.
    MissingPartError
        If FFmpeg came without the encoder.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in FILMS:
        raise OutputError(f"a video is written as {', '.join(FILMS)}, not {suffix!r}: {path}")
    film, (width, height) = FILMS[suffix], view.size
    if view.transparent and not film.clear_codec:
        raise InputError(f"{path}: {suffix} holds no transparency; give .webm, .mov, .gif or NAME%05d.png")
    if width % film.even[0] or height % film.even[1]:
        even = f"{width + width % film.even[0]} x {height + height % film.even[1]}"
        raise InputError(
            f"a video's sides are even numbers of pixels, not {width} x {height}; {even} would do, or NAME%05d.png"
        )
    codec = film.clear_codec if view.transparent else film.codec
    if codec not in av.codec.codecs_available:
        raise MissingPartError(f"{path}: this FFmpeg (of PyAV {av.__version__}) came without the encoder {codec}")


def write_video(
    animation: Animation,
    face: Face,
    path: str | Path,
    *,
    view: View | None = None,
    renderer: Pictures | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[Note, ...]:
    """Render an animation into a video file with its sound.

    Parameters
    ----------
    animation : Animation
    face : Face
    path : path-like
        Ends in one of `FILMS`. Replaced if it exists; never left half-written.
    view : View, optional
        The portrait at 1280 x 720 otherwise.
    renderer : Pictures, optional
        What ``view.renderer(face)`` gave, where it serves several files.
    progress : callable, optional
        Called with (frames done, frames in all).

    Raises
    ------
    InputError
        If the animation has no frames, or the kind of file cannot hold the view (`check_film`).
    OutputError
        If the file cannot be written.
    """
    view = view or View()
    check_film(path, view)
    pictures = drawn_frames(animation, face, path, renderer or view.renderer(face), progress)
    sound, fps = animation.utterance.audio, animation.rate.fraction
    return write_frames(pictures, fps, sound, path, view.size, view.transparent, view.quality)


def write_frames(
    pictures: Iterator[Picture],
    fps: Fraction,
    sound: Audio,
    path: str | Path,
    size: tuple[int, int],
    transparent: bool = False,
    quality: str = "full",
) -> tuple[Note, ...]:
    """Write pictures and a sound that start together as a video file.

    Parameters
    ----------
    pictures : iterator of ndarray of uint8, shape (height, width, 3 or 4)
        sRGB; a fourth number is opacity.
    fps : Fraction
        Pictures per second.
    sound : Audio
        May be empty; then the file has no sound track.
    path : path-like
        Ends in one of `FILMS`.
    size : tuple of 2 int
        Width and height of the pictures.
    transparent : bool
        Whether the pictures have an opacity, and the file is to keep it.
    quality : str
        One of `mien.face.render.view.QUALITIES`.

    Raises
    ------
    InputError
        If the kind of file cannot hold such pictures (`check_film`).
    OutputError
        If the suffix is not known, or the file cannot be written.
    """
    check_film(path, View(*size, background=TRANSPARENT if transparent else "", quality=quality))
    film = FILMS[Path(path).suffix.lower()]
    sound = _encodable(sound, film)
    options = {"fflags": "+bitexact"}  # no times of day or random numbers in the file
    options |= {"movflags": "+faststart"} if film.container in ("mp4", "mov") else {}
    with replace_when_complete(path) as unfinished:
        try:
            with av.open(str(unfinished), "w", format=film.container, options=options) as container:
                video = _video_stream(container, film, fps, size, transparent, quality)
                voice = _sound_stream(container, film, sound.rate) if len(sound) else None
                _encode(container, video, voice, pictures, fps, sound)
        except av.FFmpegError as problem:
            raise OSError(problem.errno, problem.strerror) from problem
    return ()


def _encodable(sound: Audio, film: Film) -> Audio:
    """The sound as the file can have it: at one of its rates and, where it is compressed, with room above its peak.

    What a decoder makes of compressed sound goes up to a tenth beyond the peak that was given to the encoder.
    """
    if not film.rates:
        return sound
    sound = sound if sound.rate in film.rates else sound.resampled(film.rates[0])
    peak = float(np.abs(sound.samples).max(initial=0.0))
    return sound if peak <= _LOUDEST else Audio(sound.samples * (_LOUDEST / peak), sound.rate)


def _video_stream(
    container: Any, film: Film, fps: Fraction, size: tuple[int, int], transparent: bool, quality: str
) -> Any:
    stream = container.add_stream(film.clear_codec if transparent else film.codec, rate=fps)
    stream.width, stream.height = size
    stream.pix_fmt = film.clear_pixels if transparent else film.pixels
    context = stream.codec_context
    context.color_range = 1  # 16..235
    context.color_primaries = context.color_trc = context.colorspace = 1  # BT.709
    context.gop_size = max(1, round(fps * _SECONDS_PER_KEY))
    stream.options = film.options(quality)
    if film.codec == "prores_ks":
        context.gop_size = 1
        stream.options = {**stream.options, "profile": "4444" if transparent else "hq"}
    return stream


def _sound_stream(container: Any, film: Film, rate: int) -> Any:
    stream = container.add_stream(film.voice, rate=rate, layout="mono")
    if film.voice == "libopus":
        stream.codec_context.format = "flt"
    if film.rates:
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
        frame = _frame(picture, video.pix_fmt)
        frame.pts, frame.time_base = number, 1 / fps
        container.mux(video.encode(frame))
        blocks.write_until(round((number + 1) / fps * sound.rate))
    container.mux(video.encode(None))
    blocks.write_until(len(sound))
    if voice is not None:
        container.mux(voice.encode(None))


def _frame(picture: Picture, pixels: str) -> Any:
    if pixels == "yuv420p":
        if picture.ndim != 3 or picture.shape[2] != 3:
            raise ValueError(f"a picture has the shape (height, width, 3), not {picture.shape}")
        height, width = picture.shape[:2]
        planes = np.empty((height * 3 // 2, width), dtype=np.uint8)
        luma_and_chroma(picture, planes)
        return av.VideoFrame.from_ndarray(planes, format=pixels)
    return av.VideoFrame.from_ndarray(picture, format="rgba" if picture.shape[2] == 4 else "rgb24").reformat(
        format=pixels,
        src_colorspace="ITU709",
        dst_colorspace="ITU709",
        src_color_range="JPEG",
        dst_color_range="MPEG",
        threads=1,
    )


@njit(cache=True, nogil=True)
def luma_and_chroma(picture, planes):  # type: ignore[no-untyped-def]
    """SRGB (height, width, 3) to the planes of yuv420p by BT.709, 16 to 235, one under the other; sides are even.

    What FFmpeg's scaler does, in less time.
    """
    height, width = picture.shape[0], picture.shape[1]
    half, chroma = width // 2, planes[height:].reshape(-1)
    for y in range(height):
        for x in range(width):
            r, g, b = np.int32(picture[y, x, 0]), np.int32(picture[y, x, 1]), np.int32(picture[y, x, 2])
            planes[y, x] = np.uint8((11966 * r + 40254 * g + 4064 * b + 1081344) >> 16)
    below = half * (height // 2)
    for y in range(height // 2):
        one, two = picture[2 * y], picture[2 * y + 1]
        for x in range(half):
            r, g, b = np.int32(0), np.int32(0), np.int32(0)
            for i in range(2):
                r += np.int32(one[2 * x + i, 0]) + np.int32(two[2 * x + i, 0])
                g += np.int32(one[2 * x + i, 1]) + np.int32(two[2 * x + i, 1])
                b += np.int32(one[2 * x + i, 2]) + np.int32(two[2 * x + i, 2])
            chroma[y * half + x] = np.uint8((-6596 * r - 22188 * g + 28784 * b + 33685504) >> 18)
            chroma[below + y * half + x] = np.uint8((28784 * r - 26145 * g - 2639 * b + 33685504) >> 18)


class _SoundBlocks:
    """Feeds a sound to its encoder in the blocks that it takes, the last one shorter or filled up with silence."""

    def __init__(self, container: Any, stream: Any | None, sound: Audio) -> None:
        self.container, self.stream, self.sound = container, stream, sound
        self.done, self.size, self.form = 0, _BLOCK, "fltp"
        if stream is not None:
            stream.codec_context.open()  # what size of block it takes is known from here on
            self.size = stream.codec_context.frame_size or _BLOCK
            self.form = stream.codec_context.format.name

    def write_until(self, sample: int) -> None:
        """Encode whole blocks up to ``sample``; at the end of the sound also the last, shorter one."""
        if self.stream is None:
            return
        end = min(sample, len(self.sound))
        while self.done < end and (self.done + self.size <= end or end == len(self.sound)):
            piece = self.sound.samples[self.done : min(self.done + self.size, end)]
            block = av.AudioFrame.from_ndarray(self._numbers(piece), format=self.form, layout="mono")
            block.sample_rate, block.pts, block.time_base = self.sound.rate, self.done, Fraction(1, self.sound.rate)
            self.container.mux(self.stream.encode(block))
            self.done += len(piece)

    def _numbers(self, samples: NDArray[Any]) -> NDArray[Any]:
        if self.form.startswith("flt"):
            return np.ascontiguousarray(samples[None], dtype=np.float32)
        whole: NDArray[Any] = np.rint(np.clip(samples, -1, 1)[None] * (2**31 - 1)).astype(np.int32)
        return whole
