"""The pictures of an animation, one by one, for the formats that show them all.

Each is drawn by one thread, as many at a time as there are cores: no core waits for the slowest part of a picture.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mien.animation.animation import Animation
from mien.core.errors import InputError
from mien.face.deformers import FacePoser, poser_for
from mien.face.model import Face
from mien.face.render.cores import cores
from mien.face.render.renderer import Picture
from mien.face.render.view import Pictures

__all__ = ["drawn_frames", "drawn_rows"]


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
    return drawn_rows(track.values, poser_for(face, track.names), renderer, progress)


def drawn_rows(
    rows: NDArray[np.float64],
    poser: FacePoser,
    renderer: Pictures,
    progress: Callable[[int, int], None] | None = None,
) -> Iterator[Picture]:
    """Draw a face at every row of its channels."""

    def drawn(row: NDArray[np.float64]) -> Picture:
        return renderer.render(poser.pose(row))

    waiting: deque[Future[Picture]] = deque()
    with ThreadPoolExecutor(cores(), thread_name_prefix="mien-picture") as pool:
        try:
            for number in range(len(rows)):
                for row in rows[number + len(waiting) : number + cores() + 1]:
                    waiting.append(pool.submit(drawn, row))
                yield waiting.popleft().result()
                if progress is not None:
                    progress(number + 1, len(rows))
        finally:
            for each in waiting:
                each.cancel()
