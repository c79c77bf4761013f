"""What of a take is scored: its mouth, and the frames in which speech is seen."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mien.capture.layouts import load_layout
from mien.core.errors import InputError
from mien.core.tracks import MarkerTrack
from mien.core.utterance import PAUSE
from mien.corpus.take import Take
from mien.metrics.sites import Sites, mouth_sites

__all__ = ["MARGIN", "Recording", "only_markers", "prepare"]

MARGIN = 2
"""Frames before the first phone and after the last one that are scored with it."""

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Recording:
    """A take made ready: what models learn from and are scored against.

    Attributes
    ----------
    take : Take
        With the mouth markers only.
    sites : Sites
        Where the lips are among the mouth markers.
    times : ndarray, shape (frames,)
        Seconds.
    upper : ndarray, shape (frames, upper-face markers, 3)
        Markers of the upper face, mm; none where the layout has none.
    speech : ndarray of bool, shape (frames,)
        From two frames before the first phone to two after the last, where every mouth marker was seen.
    """

    take: Take
    sites: Sites
    times: Array
    upper: Array
    speech: NDArray[np.bool_]

    @property
    def positions(self) -> Array:
        """Mouth markers, shape (frames, markers, 3), mm."""
        return self.take.markers.positions

    @property
    def bridged(self) -> Array:
        """The same with straight lines over frames in which a marker was not seen (they are not scored)."""
        seen = np.asarray(np.isfinite(self.positions).all(axis=(1, 2)))
        if seen.all():
            return self.positions
        flat = self.positions.reshape(len(seen), -1)
        columns = [np.interp(self.times, self.times[seen], column[seen]) for column in flat.T]
        return np.stack(columns, axis=1).reshape(self.positions.shape)

    @property
    def fps(self) -> float:
        """Frames per second."""
        return self.take.markers.rate.fps

    @property
    def first_phone(self) -> float:
        """Seconds at which speech begins."""
        return next(p.start for p in self.take.phones if p.label != PAUSE)

    def inside(self, words: Collection[str]) -> NDArray[np.bool_]:
        """Scored frames inside the given words, shape (frames,); all scored frames if none is given."""
        if not words:
            return self.speech
        held = np.zeros(len(self.times), dtype=bool)
        for word in self.take.words:
            if word.label.lower() in words:
                held |= (self.times >= word.start - 1e-9) & (self.times < word.end - 1e-9)
        return held & self.speech


def prepare(take: Take) -> Recording:
    """Keep the mouth of a take and find the frames to score.

    Raises
    ------
    InputError
        If the take lacks mouth markers, holds no speech, or no frame of its speech was seen whole.
    """
    try:
        layout = load_layout(take.layout)
        sites = mouth_sites(layout, take.markers.names)
    except InputError as problem:
        raise InputError(f"take {take.name!r}: {problem}") from problem
    mouth = only_markers(take, sites.mouth)
    spoken = [phone for phone in take.phones if phone.label != PAUSE]
    if not spoken:
        raise InputError(f"take {take.name!r} holds no speech: nothing to learn from or to score; leave it out")
    rate = take.markers.rate
    first, last = rate.frame_at(spoken[0].start) - MARGIN, rate.frame_at(spoken[-1].end) + MARGIN
    frames = np.arange(len(take.markers))
    seen = np.isfinite(mouth.markers.positions).all(axis=(1, 2))
    speech = (frames >= first) & (frames <= last) & seen
    if not speech.any():
        raise InputError(f"take {take.name!r}: the mouth was not seen in any frame of the speech; leave it out")
    upper_face = set(layout.groups["upper"]) - set(layout.rigid)
    upper = take.markers.positions[:, [name in upper_face for name in take.markers.names]]
    return Recording(mouth, mouth_sites(layout, mouth.markers.names), rate.times(len(frames)), upper, speech)


def only_markers(take: Take, places: Collection[int]) -> Take:
    """The same take with some of its markers."""
    kept = list(places)
    names = [take.markers.names[place] for place in kept]
    return replace(take, markers=MarkerTrack(names, take.markers.positions[:, kept], take.markers.rate))
