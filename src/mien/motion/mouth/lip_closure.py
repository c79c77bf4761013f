"""Lips shut where they must, and never pass through each other.

A smooth model rarely shuts the lips in full: squared error rewards being half-way. After synthesis the lips are
therefore drawn together at each bilabial (and towards the teeth at each labiodental) along the direction in which they
closed in the recordings, as far as they closed there and no further, and only if the model left them wider apart.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Self

import numpy as np
from numpy.typing import NDArray

from mien.core.poses import read_table
from mien.core.time_spans import is_within, places_within, seconds_away
from mien.core.timeline import Tier
from mien.core.utterance import PAUSE
from mien.motion.mouth.mouth_space import MouthSpace
from mien.motion.mouth.recorded_mouths import RecordedMouth

__all__ = ["LipClosure"]

HOLD = 0.022
"""Seconds to each side of the instant of closure for which it is held: at least one frame at 25 frames per second."""
FLANK = 0.03
"""Seconds over which the hold fades in and out, on a half cosine."""
SHORTEST_REACH = 0.03
"""Seconds about the usual instant of closure within which the model's own narrowest instant is looked for, at least."""
QUARTILE = 75.0
"""Per cent of recorded closures at which the lips came at least as close as they are drawn here."""
LEAST_APART = 1.0
"""Millimetres by which lips that no phone shuts stay apart in speech: in recordings the narrowest, of /w/ and /r/, are
wider, but learned curves that are sharpened again close them now and then, and a viewer sees a /b/ that nobody said."""
CLEAR = 0.05
"""Seconds from a phone that shuts the lips, or from a pause, at which that holds in full."""
NEARLY_SHUT = 5.0
"""Millimetres of lip opening below which frames tell the direction in which lips close."""
CLOSURES_HELD, FRAMES_HELD = 10, 200
"""Closures, and frames with lips nearly shut, that a start counts as."""
_BLOCK = 4096  # frames
_STEPS = 4  # distances and bounds are not linear in the shift: a few steps bring it home

Floats = NDArray[np.float64]


class LipClosure:
    """Learns how far, when and along which way the lips close; holds them there.

    Parameters
    ----------
    space : MouthSpace
        What the rows are.

    Attributes
    ----------
    closing_ : ndarray, shape (columns,)
        How a row changes per millimetre that the lips part; empty if the middles of the lips are not known.
    apart_ : dict of str to float
        Most lip opening for each kind of seal, mm.
    delay_ : dict of str to float
        Seconds from the middle of the phone to the usual instant of closure (negative: before). About it the lips are
        shut where the model brings them closest.
    """

    def __init__(self, space: MouthSpace) -> None:
        self.space = space
        self.seals: dict[str, str] = {
            p: kind for kind, phones in read_table("lips.toml")["seals"].items() for p in phones
        }

    def fit(self, mouths: Sequence[RecordedMouth], start: LipClosure | None = None) -> Self:
        """Learn from recorded mouths; without the middles of the lips nothing is learned and nothing held.

        ``start``: of somebody else, what counts where little was recorded.
        """
        self.closing_, self.apart_, self.delay_ = np.zeros(0), {}, {}
        rows = np.concatenate([mouth.rows for mouth in mouths])
        opening = self.space.opening_of(rows)
        if opening is None:
            return self
        least: dict[str, list[tuple[float, float]]] = {}
        for mouth in mouths:
            for kind, narrowest, delay in self._closures(mouth):
                least.setdefault(kind, []).append((narrowest, delay))
        for kind, found in sorted(least.items()):
            self.apart_[kind] = max(float(np.percentile([narrowest for narrowest, _ in found], QUARTILE)), 0.0)
            self.delay_[kind] = float(np.median([delay for _, delay in found]))
        near = opening < max(NEARLY_SHUT, float(np.percentile(opening, 25)))
        part = opening[near] - opening[near].mean()
        self.closing_ = part @ (rows[near] - rows[near].mean(axis=0)) / max(float(part @ part), 1e-9)
        if start is not None:
            for kind in start.apart_:
                count = len(least.get(kind, ()))
                own = count / (count + CLOSURES_HELD)
                self.apart_[kind] = own * self.apart_.get(kind, 0.0) + (1 - own) * start.apart_[kind]
                self.delay_[kind] = own * self.delay_.get(kind, 0.0) + (1 - own) * start.delay_[kind]
            own = near.sum() / (near.sum() + FRAMES_HELD)
            self.closing_ = own * self.closing_ + (1 - own) * start.closing_
        return self

    def hold(self, rows: Floats, phones: Tier, times: Floats) -> Floats:
        """Draw the lips together where they must be shut, and keep them apart elsewhere; shape (frames, columns)."""
        rows = rows.copy()
        opening = self.space.opening_of(rows)
        if self.apart_ and opening is not None:
            for phone in (one for one in phones if self.seals.get(one.label) in self.apart_):
                kind, reach = self.seals[phone.label], max(phone.duration / 2, SHORTEST_REACH)
                middle = phone.middle + self.delay_.get(kind, 0.0)
                near = places_within(times, middle - reach, middle + reach)
                if near.start < near.stop:
                    closest = times[near][opening[near].argmin()]
                    drawn = places_within(times, closest - HOLD - FLANK, closest + HOLD + FLANK)
                    rows[drawn] = self._drawn_together(
                        rows[drawn], _fade(np.abs(times[drawn] - closest)), self.apart_[kind]
                    )
            self._keep_apart(rows, phones, times)
        for first in range(0, len(rows), _BLOCK):  # a long line is not held many times over
            rows[first : first + _BLOCK] = self.space.parted(rows[first : first + _BLOCK], self.closing_)
        return rows

    def _keep_apart(self, rows: Floats, phones: Tier, times: Floats) -> None:
        """In speech away from pauses and from phones that shut the lips, bring them at least `LEAST_APART` apart."""
        rest = self.space.rest()
        if rest is None:
            return
        shuts = [phone for phone in phones if phone.label in self.seals or phone.label == PAUSE]
        open_ = [phone for phone in phones if phone.label not in self.seals and phone.label != PAUSE]
        free = np.minimum(is_within(open_, times), seconds_away(shuts, times) / CLEAR)
        least = max(float(self._opening(rest[None])[0]), 0.0) + LEAST_APART
        lacking = free * np.maximum(least - self._opening(rows), 0.0)
        for first in range(0, len(rows), _BLOCK):
            rows[first : first + _BLOCK] += lacking[first : first + _BLOCK, None] * self.closing_

    def _closures(self, mouth: RecordedMouth) -> list[tuple[str, float, float]]:
        """Kind, least opening and its time from the middle, of each seal inside speech."""
        opening = self._opening(mouth.rows)
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

    def _opening(self, rows: Floats) -> Floats:
        found = self.space.opening_of(rows)
        return np.zeros(len(rows)) if found is None else found

    def _drawn_together(self, rows: Floats, strength: Floats, apart: float) -> Floats:
        """Closed along the learned way where the lips stand wider than ``apart``: by ``strength`` of the excess."""
        rows = rows.copy()
        touched = np.flatnonzero(strength > 0)
        for _ in range(_STEPS):
            here = self.space.rows_from(self.space.motion_of(rows[touched]))
            excess = np.maximum(self._opening(here) - apart, 0.0)
            rows[touched] = here - (strength[touched] * excess)[:, None] * self.closing_
            strength = np.where(strength >= 1, 1.0, 0.0)  # the flanks are moved once, the hold until it is shut
        return rows


def _fade(distance: Floats) -> Floats:
    """1 within `HOLD`, falling to 0 over `FLANK`."""
    return np.asarray((1 + np.cos(np.pi * np.clip((distance - HOLD) / FLANK, 0, 1))) / 2)
