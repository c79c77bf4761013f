"""The pictures of an animation, one by one, for the formats that show them all."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

from mien.animation.animation import Animation
from mien.core.errors import InputError
from mien.face.deformers import poser_for
from mien.face.model import Face
from mien.face.render.renderer import Picture
from mien.face.render.view import Pictures

__all__ = ["drawn_frames"]


def drawn_frames(
    animation: Animation,
    face: Face,
    path: str | Path,
    renderer: Pictures,
    progress: Callable[[int, int], None] | None = None,
) -> Iterator[Picture]:
    """Draw every frame; ``progress`` is called with (frames done, frames in all).

    Raises
    ------
    InputError
        At once, if the animation has no frames.
    """
    track = animation.channels
    if len(track) == 0:
        raise InputError(f"cannot write {path}: the animation has no frames")
    poser = poser_for(face, track.names)

    def pictures() -> Iterator[Picture]:
        for number, row in enumerate(track.values):
            yield renderer.render(poser.pose(row))
            if progress is not None:
                progress(number + 1, len(track))

    return pictures()
