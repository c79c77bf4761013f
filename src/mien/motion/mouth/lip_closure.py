"""Lips shut where they must, and never pass through each other.

A smooth model rarely shuts the lips in full: squared error rewards being half-way. After synthesis the lips are
therefore drawn together at each bilabial (and towards the teeth at each labiodental) along the direction in which they
closed in the recordings, as far as they closed there and no further, and only if the model left them wider apart.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from mien.capture.layouts import load_layout
from mien.core.poses import read_table
from mien.core.timeline import Tier
from mien.motion.mouth.recorded_mouths import RecordedMouth

__all__ = ["LipClosure", "LipPlaces", "find_lips"]

HOLD = 0.022
"""Seconds to each side of the instant of closure for which it is held: at least one frame at 25 frames per second."""
FLANK = 0.03
"""Seconds over which the hold fades in and out, on a half cosine."""
SHORTEST_REACH = 0.03
"""Seconds about the usual instant of closure within which the model's own narrowest instant is looked for, at least."""
QUARTILE = 75.0
"""Per cent of recorded closures at which the lips came at least as close as they are drawn here."""
NEARLY_SHUT = 5.0
"""Millimetres of lip opening below which frames tell the direction in which lips close."""

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class LipPlaces:
    """Where the lips are among markers.

    Attributes
    ----------
    opening : tuple of (int, int), or None
        Middles of the upper and the lower lip; None if the markers lack them.
    facing : tuple of (int, int)
        Points of the inner upper lip and those of the lower lip under them.
    """

    opening: tuple[int, int] | None
    facing: tuple[tuple[int, int], ...]


def find_lips(layout: str, names: Sequence[str]) -> LipPlaces:
    """Find the lips among the markers of a layout.

    Examples
    --------
    >>> find_lips("mpeg4-32", ("8.1", "8.2", "8.3"))
    LipPlaces(opening=(0, 1), facing=())
    """
    table = read_table("lips.toml")
    place = {name: number for number, name in enumerate(names)}
    landmarks = load_layout(layout).landmarks
    opening = next(((place[a], place[b]) for a, b in table["opening"]["choices"] if a in place and b in place), None)
    named = [(landmarks.get(a, ""), landmarks.get(b, "")) for a, b in table["facing"]["mediapipe"]]
    named += [(a, b) for a, b in table["facing"]["mpeg4"] if (a, b) not in named]
    return LipPlaces(opening, tuple((place[a], place[b]) for a, b in named if a in place and b in place))


class LipClosure:
    """Learns how far, when and along which way the lips close; holds them there.

    Parameters
    ----------
    lips : LipPlaces

    Attributes
    ----------
    closing_ : ndarray, shape (markers, 3)
        How the mouth moves per millimetre that the lips part.
    apart_ : dict of str to float
        Most lip opening for each kind of seal, mm.
    delay_ : dict of str to float
        Seconds from the middle of the phone to the usual instant of closure (negative: before). About it the lips are
        shut where the model brings them closest.
    """

    def __init__(self, lips: LipPlaces) -> None:
        self.lips = lips
        self.seals: dict[str, str] = {
            p: kind for kind, phones in read_table("lips.toml")["seals"].items() for p in phones
        }

    def fit(self, mouths: Sequence[RecordedMouth]) -> Self:
        """Learn from recorded mouths; without markers in the middle of the lips nothing is learned and nothing held."""
        self.closing_, self.apart_, self.delay_ = np.zeros((0, 3)), {}, {}
        if self.lips.opening is None:
            return self
        least: dict[str, list[tuple[float, float]]] = {}
        for mouth in mouths:
            for kind, narrowest, delay in self._closures(mouth):
                least.setdefault(kind, []).append((narrowest, delay))
        for kind, found in sorted(least.items()):
            self.apart_[kind] = float(np.percentile([narrowest for narrowest, _ in found], QUARTILE))
            self.delay_[kind] = float(np.median([delay for _, delay in found]))
        poses = np.concatenate([mouth.positions for mouth in mouths]).reshape(-1, mouths[0].positions.shape[1] // 3, 3)
        opening = self._opening(poses)
        near = opening < max(NEARLY_SHUT, float(np.percentile(opening, 25)))
        part = opening[near] - opening[near].mean()
        self.closing_ = np.tensordot(part, poses[near] - poses[near].mean(axis=0), axes=1) / max(part @ part, 1e-9)
        return self

    def hold(self, positions: Floats, phones: Tier, times: Floats) -> Floats:
        """Draw the lips together where they must be shut; shape (frames, markers, 3), mm, in and out."""
        positions = positions.copy()
        if self.apart_ and self.lips.opening is not None:
            opening = self._opening(positions)
            for phone in phones:
                kind = self.seals.get(phone.label, "")
                reach = max(phone.duration / 2, SHORTEST_REACH)
                near = np.flatnonzero(np.abs(times - phone.middle - self.delay_.get(kind, 0.0)) <= reach)
                if kind in self.apart_ and len(near):
                    closest = times[near[opening[near].argmin()]]
                    self._draw_together(positions, _fade(np.abs(times - closest)), self.apart_[kind])
        self._part_facing(positions)
        return positions

    def _closures(self, mouth: RecordedMouth) -> list[tuple[str, float, float]]:
        """Kind, least opening and its time from the middle, of each seal inside speech."""
        opening = self._opening(mouth.positions.reshape(len(mouth.times), -1, 3))
        found = []
        for before, phone, after in zip(
            mouth.phones, mouth.phones.intervals[1:], mouth.phones.intervals[2:], strict=False
        ):
            kind = self.seals.get(phone.label, "")
            near = np.flatnonzero((mouth.times >= phone.start - 0.04) & (mouth.times < phone.end + 0.02))
            if kind and len(near) and "SIL" not in (before.label, after.label):
                least = near[opening[near].argmin()]
                found.append((kind, float(opening[least]), float(mouth.times[least] - phone.middle)))
        return found

    def _opening(self, positions: Floats) -> Floats:
        upper, lower = self.lips.opening or (0, 0)
        return np.asarray(np.linalg.norm(positions[:, upper] - positions[:, lower], axis=1))

    def _draw_together(self, positions: Floats, strength: Floats, apart: float) -> None:
        """Close along the learned way where the lips stand wider than ``apart``: by ``strength`` of the excess."""
        touched = np.flatnonzero(strength > 0)
        for _ in range(4):  # the distance is not linear in the shift: a few steps bring it home
            excess = np.maximum(self._opening(positions[touched]) - apart, 0.0)
            positions[touched] -= (strength[touched] * excess)[:, None, None] * self.closing_
            strength = np.where(strength >= 1, 1.0, 0.0)  # the flanks are moved once, the hold until it is shut

    def _part_facing(self, positions: Floats) -> None:
        """Where an inner upper lip is below the lower lip, both meet half-way (y points up)."""
        for upper, lower in self.lips.facing:
            through = np.maximum(positions[:, lower, 1] - positions[:, upper, 1], 0.0) / 2
            positions[:, upper, 1] += through
            positions[:, lower, 1] -= through


def _fade(distance: Floats) -> Floats:
    """1 within `HOLD`, falling to 0 over `FLANK`."""
    return np.asarray((1 + np.cos(np.pi * np.clip((distance - HOLD) / FLANK, 0, 1))) / 2)
