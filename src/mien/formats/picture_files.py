"""``.gif`` and ``NAME%05d.png``: the performance as pictures without sound, each of which can be transparent."""

from __future__ import annotations

import re
from collections.abc import Callable
from fractions import Fraction
from itertools import islice, pairwise
from pathlib import Path

import numpy as np
from PIL import Image

from mien.animation.animation import Animation
from mien.core.errors import InputError, Note
from mien.core.files import folder_until_complete, replace_when_complete
from mien.face.model import Face
from mien.face.render.renderer import Picture
from mien.face.render.view import View
from mien.formats.drawn_frames import drawn_frames

__all__ = ["frame_files", "is_frame_pattern", "write_gif", "write_png_frames"]

_NUMBER = re.compile(r"%0?(\d*)d")
_GIF_MOST_FPS = 50  # a picture stays for 1/100 s or more, and players show less than 2/100 slowly
_OPAQUE = 128  # of 255: GIF has no half-transparent pixels


def is_frame_pattern(path: str | Path) -> bool:
    """Whether a name stands for one file a frame.

    Examples
    --------
    >>> is_frame_pattern("line%05d.png"), is_frame_pattern("line.png")
    (True, False)
    """
    return Path(path).suffix.lower() == ".png" and _NUMBER.search(Path(path).name) is not None


def frame_files(path: str | Path, frames: int) -> list[Path]:
    """The names that a pattern stands for, from frame 0.

    Raises
    ------
    InputError
        If the pattern has two numbers or another sign for numbers.

    Examples
    --------
    >>> [file.name for file in frame_files("line%03d.png", 2)]
    ['line000.png', 'line001.png']
    """
    path = Path(path)
    if len(_NUMBER.findall(path.name)) != 1:
        raise InputError(f"{path}: the number of a frame stands in a name once, as %05d")
    digits = int(_NUMBER.search(path.name)[1] or 1)  # type: ignore[index]
    if digits > 9:
        raise InputError(f"{path}: a frame's number has up to 9 digits, not {digits}")
    return [path.with_name(_NUMBER.sub(f"{number:0{digits}d}", path.name)) for number in range(frames)]


def write_png_frames(
    animation: Animation,
    face: Face,
    path: str | Path,
    *,
    view: View | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[Note, ...]:
    """One PNG for every frame; frame ``i`` has number ``i``. The files take their names when all are drawn.

    Parameters
    ----------
    animation : Animation
    face : Face
    path : path-like
        With a number such as ``%05d`` in its name.
    view : View, optional
    progress : callable, optional
        Called with (frames done, frames in all).

    Raises
    ------
    InputError
        If the animation has no frames, or the name is no pattern.
    OutputError
        If a file cannot be written.
    """
    files = frame_files(path, len(animation.channels))
    pictures = drawn_frames(animation, face, path, (view or View()).renderer(face), progress)
    with folder_until_complete(path) as folder:
        for file, picture in zip(files, pictures, strict=True):
            Image.fromarray(picture).save(folder / file.name, format="PNG", compress_level=3)
        for file in files:
            (folder / file.name).replace(file)
    following = frame_files(path, len(files) + 1)[-1]
    message = f"{following.name} and what may follow it are of an earlier run: this one has {len(files)} frames"
    return (Note("warning", message),) if following.exists() else ()


def write_gif(
    animation: Animation,
    face: Face,
    path: str | Path,
    *,
    view: View | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[Note, ...]:
    """An animated GIF: 256 colours a picture, no sound, times in 1/100 s that do not drift.

    Parameters as for `write_png_frames`.

    Returns
    -------
    tuple of Note
        That frames were left out, where there are more a second than GIF shows.

    Raises
    ------
    InputError
        If the animation has no frames.
    OutputError
        If the file cannot be written.
    """
    fps = animation.rate.fraction
    step = -(-fps // _GIF_MOST_FPS)
    pictures = drawn_frames(animation, face, path, (view or View()).renderer(face), progress)
    shown = (_in_256_colours(picture) for picture in islice(pictures, 0, None, step))
    first = next(shown)
    with replace_when_complete(path) as unfinished:
        first.save(
            unfinished,
            format="GIF",
            save_all=True,
            append_images=shown,
            duration=_durations(len(animation.channels), fps, step),
            loop=0,
            disposal=2 if first.info.get("transparency") is not None else 1,
            optimize=False,
        )
    if step == 1:
        return ()
    return (Note("note", f"GIF shows {_GIF_MOST_FPS} pictures a second at most: every {step} frames one is in {path}"),)


def _durations(frames: int, fps: Fraction, step: int) -> list[int]:
    """Milliseconds that each picture stays: whole hundredths, so rounded that no error adds up."""
    ends = [round(100 * min(number + step, frames) / fps) for number in range(-step, frames, step)]
    return [10 * max(1, after - before) for before, after in pairwise(ends)]


def _in_256_colours(picture: Picture) -> Image.Image:
    """A picture with a palette of its own; the last colour stands for what is transparent."""
    if picture.shape[2] == 3:
        return _nearest(picture, 256)
    image = _nearest(np.ascontiguousarray(picture[..., :3]), 255)
    indices = np.where(picture[..., 3] >= _OPAQUE, np.asarray(image), 255).astype(np.uint8)
    palette = image.getpalette()
    shown = Image.fromarray(indices, mode="P")
    shown.putpalette((palette or []) + [0] * (768 - len(palette or [])))
    shown.info["transparency"] = 255
    return shown


def _nearest(picture: Picture, colours: int) -> Image.Image:
    """Each pixel in the nearest of so many colours, cut by the median.

    Every shade counts by the root of its pixels: lips and teeth are few beside skin and background, and lose their
    colour where every pixel counts.
    """
    shades = (picture >> 2).astype(np.int32) @ np.array([4096, 64, 1], np.int32)
    _, first, pixels = np.unique(shades, return_index=True, return_counts=True)
    counted = np.repeat(picture.reshape(-1, 3)[first], np.ceil(np.sqrt(pixels)).astype(int), axis=0)
    palette = Image.fromarray(counted[np.newaxis]).quantize(colours, method=Image.Quantize.MEDIANCUT)
    return Image.fromarray(picture).quantize(palette=palette, dither=Image.Dither.NONE)
