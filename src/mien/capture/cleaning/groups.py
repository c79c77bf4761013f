"""The three motion groups of a face: rigid head, upper face, mouth (Cao et al. 2005, section 3.2)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.capture.cleaning.normalise import columns
from mien.core.errors import InputError
from mien.core.tracks import MarkerTrack

__all__ = ["MarkerGroups", "MotionGroups", "select", "split"]


@dataclass(frozen=True)
class MarkerGroups:
    """Which markers of a layout do what.

    Attributes
    ----------
    rigid : tuple of str
        Markers that move with the head only: they carry the head's motion. At least three.
    upper_face, mouth : tuple of str
        Markers of the two groups that move in the head; together with those of ``rigid`` they need not be all.
    nose, left_eye, right_eye : str
        The three points of Deng et al. 2006, section IV: nose, corners of the eyes (the speaker's left and right).
    upper_lip, lower_lip : str
        The middle of the inner lips, whose distance is the opening of the mouth.

    Raises
    ------
    InputError
        If there are fewer than three rigid markers, or a marker is both of the upper face and of the mouth.
    """

    rigid: tuple[str, ...]
    upper_face: tuple[str, ...]
    mouth: tuple[str, ...]
    nose: str
    left_eye: str
    right_eye: str
    upper_lip: str
    lower_lip: str

    def __post_init__(self) -> None:
        if len(set(self.rigid)) < 3:
            raise InputError(f"marker groups: expected at least three rigid markers, got {len(set(self.rigid))}")
        both = sorted(set(self.upper_face) & set(self.mouth))
        if both:
            raise InputError(f"marker groups: {both} are in the upper face and in the mouth; keep each in one group")

    @property
    def names(self) -> tuple[str, ...]:
        """Every marker named anywhere, each once, in order."""
        roles = (self.nose, self.left_eye, self.right_eye, self.upper_lip, self.lower_lip)
        return tuple(dict.fromkeys((*self.rigid, *self.upper_face, *self.mouth, *roles)))

    def without(self, dropped: Sequence[str]) -> MarkerGroups:
        """The same groups less some markers of ``rigid``, ``upper_face`` and ``mouth``; the named roles stay."""
        gone = set(dropped)
        keep = [tuple(n for n in group if n not in gone) for group in (self.rigid, self.upper_face, self.mouth)]
        return MarkerGroups(
            keep[0], keep[1], keep[2], self.nose, self.left_eye, self.right_eye, self.upper_lip, self.lower_lip
        )


@dataclass(frozen=True, eq=False)
class MotionGroups:
    """A performance in its three motion groups.

    Attributes
    ----------
    head : ndarray, shape (frames, 4, 4)
        The rigid motion of the head.
    upper_face, mouth : MarkerTrack
        In the head of the reference frame, mm.
    """

    head: NDArray[np.float64]
    upper_face: MarkerTrack
    mouth: MarkerTrack


def select(track: MarkerTrack, names: Sequence[str]) -> MarkerTrack:
    """The named markers of a track, in the given order."""
    return MarkerTrack(names, track.positions[:, columns(track, names)], track.rate)


def split(normalised: MarkerTrack, head: NDArray[np.float64], groups: MarkerGroups) -> MotionGroups:
    """Split normalised motion into head, upper face and mouth.

    Parameters
    ----------
    normalised : MarkerTrack
    head : ndarray, shape (frames, 4, 4)
        As `normalise.least_squares` gives both.
    groups : MarkerGroups

    Raises
    ------
    InputError
        If a marker of the groups is not in the track, or head and track differ in length.
    """
    if head.shape != (len(normalised), 4, 4):
        raise InputError(f"head motion: expected shape ({len(normalised)}, 4, 4), got {head.shape}")
    return MotionGroups(head, select(normalised, groups.upper_face), select(normalised, groups.mouth))
