"""Video of a face, tracked frame by frame."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.capture.layouts import load_layout
from mien.capture.tracker import TrackerError, shared_tracker, tracker_python
from mien.core.errors import InputError, Note
from mien.core.timeline import FrameRate
from mien.core.tracks import MarkerTrack
from mien.corpus.readers.raw_recordings import Found, Raw, Reader
from mien.corpus.readers.recording_files import VIDEO, found_by_suffix, has_suffix
from mien.corpus.recipes import Recipe
from mien.formats.media import open_media
from mien.formats.sound_files import read_audio

__all__ = ["READER", "read_video", "steady_frames"]

ENLARGED_BELOW = 960
"""Pictures whose longer side has fewer pixels are enlarged twice: the tracker's grid is coarse."""
_LONGEST_GAP = 600.0
"""Seconds between two pictures; more is a damaged time stamp, and would be hours of the same picture."""
_MATRIX = "<9i"


def _needs() -> None:
    tracker_python()


def _find(source: Path) -> list[Found]:
    return found_by_suffix(source, VIDEO)


def _read(found: Found, recipe: Recipe) -> Raw:
    return read_video(found, recipe)


def read_video(found: Found, recipe: Recipe) -> Raw:
    """Track one video; pixels of the picture as recorded."""
    path = found.motion
    layout = load_layout(recipe.layout or "mediapipe-218")
    if len(layout.landmarks) < len(layout.markers):
        raise InputError(
            f"{path}: the tracker gives MediaPipe's landmarks; layout {layout.name} has markers without one"
        )
    rate, scale, frames = steady_frames(path, recipe.fps)
    try:
        points = shared_tracker().landmarks(frames) / scale
    except TrackerError as problem:
        raise InputError(f"{path}: {problem}") from problem
    if not len(points):
        raise InputError(f"{path}: holds no picture")
    lost = np.isnan(points[:, 0, 0])
    if lost.all():
        raise InputError(
            f"{path}: no face found in any of {len(lost)} frames: is the face in the picture, upright and lit?"
        )
    names = {name: number for number, name in layout.landmarks.items()}
    track = MarkerTrack(layout.markers, points[:, [names[marker] for marker in layout.markers]], rate)
    audio, notes = read_audio(found.sound or path)
    notes += (Note("note", f"{path.name}: pictures enlarged {scale:g} times for the tracker"),) if scale != 1 else ()
    return Raw(track, "pixels", audio, notes=notes)


def steady_frames(path: Path, fps: float = 0.0) -> tuple[FrameRate, float, Iterator[NDArray[np.uint8]]]:
    """Pictures of a video at a steady rate, frame 0 at the start of its sound.

    Phones record at a rate that wanders: each frame of the steady rate is the recorded picture nearest in time.

    Parameters
    ----------
    path : Path
    fps : float
        The rate; 0: the video's mean rate.

    Returns
    -------
    rate : FrameRate
    scale : float
        How many times the pictures are enlarged.
    frames : iterator of ndarray of uint8, shape (height, width, 3)
        RGB.

    Raises
    ------
    InputError
        If the file is no video; later, while iterating, if it is damaged: the message names the time.
    """
    with open_media(path, "a video") as container:
        if not container.streams.video:
            raise InputError(f"{path}: expected a video, got a file without pictures")
        stream = container.streams.video[0]
        mean = stream.average_rate or stream.guessed_rate
        if not (fps or mean):
            raise InputError(f"{path}: its frame rate is not known; give fps in a recipe")
        rate = FrameRate.of(fps or Fraction(mean or 0).limit_denominator(1001))
        scale = 2.0 if max(stream.width, stream.height) < ENLARGED_BELOW else 1.0
        sound = container.streams.audio[0] if container.streams.audio else None
        start = None
        if sound is not None and sound.start_time is not None and sound.time_base is not None:
            start = float(sound.start_time * sound.time_base)
    return rate, scale, _pictures(path, rate, scale, start)


def _pictures(path: Path, rate: FrameRate, scale: float, start: float | None) -> Iterator[NDArray[np.uint8]]:
    """Each recorded picture as often as the steady rate asks for it."""
    tick, held, held_time = 0, None, 0.0
    for time, frame in _recorded(path, rate):
        start = time if start is None else start
        if abs(time - (start if held is None else held_time)) > _LONGEST_GAP:
            raise InputError(
                f"{path}: the pictures jump from {held_time - start:.2f} s to {time - start:.2f} s: is it damaged?"
            )
        if held is not None:
            while rate.time_of(tick) < (held_time + time) / 2 - start:
                yield _rgb(held, scale)
                tick += 1
        held, held_time = frame, time
    while held is not None and rate.time_of(tick) < held_time - (start or 0.0) + 0.5 / rate.fps:
        yield _rgb(held, scale)
        tick += 1


def _recorded(path: Path, rate: FrameRate) -> Iterator[tuple[float, Any]]:
    import av

    time = 0.0
    with open_media(path, "a video") as container:
        stream = container.streams.video[0]
        try:
            for number, frame in enumerate(container.decode(stream)):
                time = frame.time if frame.time is not None else rate.time_of(number)
                yield time, frame
        except av.FFmpegError as problem:
            raise InputError(
                f"{path}: the pictures break off after {time:.2f} s: the file is damaged or cut short"
            ) from problem


def _to_show(frame: Any) -> list[Any]:
    """How a picture is turned and mirrored to be seen as it was: phones hold it as the sensor lies.

    The matrix (a b u, c d v, x y w, whole numbers) takes a place to (a x + c y, b x + d y), x right and y down.
    """
    from av.sidedata.sidedata import Type
    from PIL.Image import Transpose

    told = frame.side_data.get(Type.DISPLAYMATRIX)
    if told is None or len(bytes(told)) < struct.calcsize(_MATRIX):
        return []
    a, b, _, c, d, *_ = struct.unpack_from(_MATRIX, bytes(told))
    swapped = abs(b) + abs(c) > abs(a) + abs(d)
    across, down = (c, b) if swapped else (a, d)
    changes = [Transpose.TRANSPOSE] if swapped else []
    changes += [Transpose.FLIP_LEFT_RIGHT] if across < 0 else []
    return changes + ([Transpose.FLIP_TOP_BOTTOM] if down < 0 else [])


def _rgb(frame: Any, scale: float) -> NDArray[np.uint8]:
    from PIL import Image

    picture = frame.to_image()
    for change in _to_show(frame):
        picture = picture.transpose(change)
    if scale != 1.0:
        picture = picture.resize(
            (round(picture.width * scale), round(picture.height * scale)), Image.Resampling.BICUBIC
        )
    return np.asarray(picture)


READER = Reader(
    "video", "video files of one face with its sound", lambda source: has_suffix(source, VIDEO), _find, _read, _needs
)
