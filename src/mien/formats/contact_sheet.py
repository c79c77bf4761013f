"""``.png``: a contact sheet, the key frames of a performance side by side with their phones and times."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from mien.animation.animation import Animation
from mien.core.assets import asset
from mien.core.errors import InputError, Note, OutputError
from mien.core.files import replace_when_complete
from mien.core.utterance import PAUSE
from mien.face.deformers import poser_for
from mien.face.model import Face
from mien.face.render.view import View

__all__ = ["contact_sheet", "key_frames", "write_contact_sheet"]

Picture = NDArray[np.uint8]
_MOST, _COLUMNS = 24, 6
_CELL = (320, 360)  # width, height of one picture
_GAP, _PAPER, _INK = 6, (246, 246, 244), (40, 40, 44)


def contact_sheet(images: Sequence[Picture], labels: Sequence[str], columns: int) -> Picture:
    """Lay pictures of one size out in rows, each with its label underneath.

    Parameters
    ----------
    images : sequence of ndarray of uint8, shape (height, width, 3)
    labels : sequence of str
        One for each picture; may be empty texts.
    columns : int
        Pictures in a row, at least 1.

    Returns
    -------
    ndarray of uint8, shape (sheet height, sheet width, 3)

    Raises
    ------
    InputError
        If there is no picture, sizes differ, or there is not one label for each.

    Examples
    --------
    >>> contact_sheet([np.zeros((40, 30, 3), np.uint8)] * 3, ["a", "b", "c"], columns=2).shape
    (138, 78, 3)
    """
    if not images or len(images) != len(labels) or columns < 1:
        raise InputError(
            f"a contact sheet needs pictures, a label for each and a column: got {len(images)} pictures, "
            f"{len(labels)} labels, {columns} columns"
        )
    height, width = images[0].shape[:2]
    if any(image.shape != (height, width, 3) for image in images):
        raise InputError(f"pictures on a contact sheet share one size; got {sorted({i.shape for i in images})}")
    text = max(14, min(26, width // 14))
    step_x, step_y = width + _GAP, height + text + 2 * _GAP
    columns = min(columns, len(images))
    rows = -(-len(images) // columns)
    sheet = Image.new("RGB", (columns * step_x + _GAP, rows * step_y + _GAP), _PAPER)
    draw, font = ImageDraw.Draw(sheet), ImageFont.truetype(asset("fonts/dejavu-sans.ttf"), text)
    for number, (image, label) in enumerate(zip(images, labels, strict=True)):
        x, y = _GAP + number % columns * step_x, _GAP + number // columns * step_y
        sheet.paste(Image.fromarray(image), (x, y))
        draw.text((x + width / 2, y + height + _GAP / 2 + text / 2), label, fill=_INK, font=font, anchor="mm")
    return np.asarray(sheet)


def key_frames(animation: Animation, most: int = _MOST) -> list[tuple[int, str]]:
    """Frames worth looking at, with the label of the phone that each shows; none where nothing is said at all.

    The middle of every phone; pauses only where nothing is said at all or at the start; when there are more than
    ``most``, evenly chosen ones of them.

    Returns
    -------
    list of (frame, label)
        In order of time; each frame once.
    """
    phones = list(animation.utterance.spelled_phones)
    spoken = [phone for number, phone in enumerate(phones) if number == 0 or phone.label != PAUSE]
    last = len(animation.channels) - 1
    found = {min(animation.rate.nearest_frame(phone.middle), last): phone.label for phone in spoken}
    if len(found) < 2:  # nothing said: evenly through time
        found = {int(f): "" for f in np.linspace(0, last, min(most, last + 1)).round()}
    frames = sorted(found.items())
    if len(frames) > most:
        frames = [frames[int(i)] for i in np.linspace(0, len(frames) - 1, most).round()]
    return frames


def write_contact_sheet(
    animation: Animation, face: Face, path: str | Path, *, view: View | None = None
) -> tuple[Note, ...]:
    """Render the key frames of an animation (`key_frames`) onto one PNG picture.

    Parameters
    ----------
    animation : Animation
    face : Face
    path : path-like
        Ends in ``.png``. Replaced if it exists.
    view : View, optional
        Of each picture; the head at 320 x 360 otherwise.

    Raises
    ------
    InputError
        If the animation has no frames.
    OutputError
        If the suffix is not ``.png``, or the file cannot be written.
    """
    if len(animation.channels) == 0:
        raise InputError(f"cannot write {path}: the animation has no frames")
    if Path(path).suffix.lower() != ".png":
        raise OutputError(f"a contact sheet is written as .png, not {Path(path).suffix!r}: {path}")
    poser = poser_for(face, animation.channels.names)
    renderer = (view or View(camera="head")).of_size(*_CELL).renderer(face)
    frames = key_frames(animation)
    images = [renderer.render(poser.pose(animation.channels.values[frame])) for frame, _ in frames]
    labels = [f"{label}  {animation.rate.time_of(frame):.2f} s".lstrip() for frame, label in frames]
    with replace_when_complete(path) as unfinished:
        Image.fromarray(contact_sheet(images, labels, _COLUMNS)).save(unfinished, format="PNG")
    return ()
