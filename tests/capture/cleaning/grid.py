"""A handful of takes of grid-s1, normalised as its README says lip-sync is scored."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from mien.capture.cleaning.groups import MarkerGroups
from mien.capture.cleaning.normalise import least_squares
from mien.capture.cleaning.perspective import scaled, to_millimetres
from mien.core.audio import Audio
from mien.core.timeline import FrameRate
from mien.core.tracks import MarkerTrack
from mien.formats.sound_files import read_audio


def _ids(text: str) -> tuple[str, ...]:
    return tuple(text.split())


RIGID = _ids("33 133 362 263 168 6 197 195 5 10 151 9 8 1 4 98 327")
OUTER_LIPS = _ids("61 146 91 181 84 17 314 405 321 375 291 409 270 269 267 0 37 39 40 185")
INNER_LIPS = _ids("78 95 88 178 87 14 317 402 318 324 308 415 310 311 312 13 82 81 80 191")
CHIN = _ids("152 175 199 200 148 377 176 400")
MOUTH = OUTER_LIPS + INNER_LIPS + CHIN
UPPER = _ids("70 63 105 66 107 336 296 334 293 300 159 145 386 374")
LIPS = ("13", "14")
GROUPS = MarkerGroups(RIGID, UPPER, MOUTH, "4", "263", "33", *LIPS)


class Grid:
    """The folder of grid-s1, read once."""

    def __init__(self, shared: Path) -> None:
        self.folder = shared / "grid-s1"
        about = json.loads((self.folder / "meta.json").read_text())
        self.landmarks = [str(i) for i in about["landmark_ids"]]
        self.pixel_scale = float(about["position_scale"])
        self.rate = FrameRate.of(about["fps"])
        self._markers = np.load(self.folder / "markers.npz")
        self.names = sorted(self._markers.files)
        first = to_millimetres(self.pixels(self.names[0]), ("33", "263"), frame=0)
        self.mm_per_pixel, self.reference = first.mm_per_pixel, first.track.positions[0]

    def pixels(self, name: str) -> MarkerTrack:
        """As the tracker gave them: pixels, NaN where it lost the face."""
        stored = self._markers[name]
        return MarkerTrack(self.landmarks, np.where(stored == -32768, np.nan, stored / self.pixel_scale), self.rate)

    def millimetres(self, name: str) -> MarkerTrack:
        """Millimetres on the scale of the first frame of the set, with the head's motion."""
        return scaled(self.pixels(name), self.mm_per_pixel)

    def normalised(self, name: str) -> MarkerTrack:
        """As lip-sync is scored: a similarity per frame to the first frame of the set."""
        return least_squares(self.millimetres(name), RIGID, self.reference, scale=True).track

    def words(self, name: str) -> list[tuple[float, float, str]]:
        """Start, end (s), word."""
        rows = (line.split() for line in (self.folder / "words" / f"{name}.align").read_text().splitlines())
        return [(int(start) / 25000, int(end) / 25000, word) for start, end, word in rows]

    def audio(self, name: str) -> Audio:
        return read_audio(self.folder / "audio" / f"{name}.flac")[0]
