"""Faces in motion with known differences, for the tests of the metrics."""

from __future__ import annotations

import numpy as np

from mien.core.timeline import FrameRate, Interval, Tier
from mien.core.tracks import ChannelTrack
from mien.metrics.face_track import FaceTrack

RATE = FrameRate.of(25)
TIMES = RATE.times(100)
JAW = 0.3 + 0.15 * np.sin(8 * TIMES) + 0.1 * np.sin(13 * TIMES + 1)
PHONES = Tier(
    "phones",
    (
        Interval(0.0, 0.8, "SIL"),
        Interval(0.8, 1.2, "AA"),
        Interval(1.2, 1.4, "M"),
        Interval(1.4, 2.0, "IY"),
        Interval(2.0, 2.2, "B"),
        Interval(2.2, 3.0, "AA"),
        Interval(3.0, 4.0, "SIL"),
    ),
)


def shown(phones: Tier | None = None, **curves: np.ndarray) -> FaceTrack:
    """The default face with these channels."""
    return FaceTrack.of_channels(
        ChannelTrack(tuple(curves), np.stack(list(curves.values()), axis=1), RATE), "it", phones
    )


def speaking(*, shut: tuple[tuple[float, float], ...] = ((1.2, 1.4), (2.0, 2.2))) -> FaceTrack:
    """A jaw that moves and shuts in these stretches; phones as `PHONES`."""
    jaw = JAW.copy()
    for start, end in shut:
        jaw[(start <= TIMES) & (end > TIMES)] = 0.0
    return shown(PHONES, jawOpen=jaw)
