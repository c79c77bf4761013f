"""Moving borders between phones: the tier stays whole, every phone keeps some length."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mien.animation.edits.applied import Lost
from mien.animation.edits.edited_places import Gone, Places
from mien.animation.edits.layer import EditLayer
from mien.core.errors import Note
from mien.core.timeline import Interval, Tier
from mien.core.utterance import Utterance

__all__ = ["LEAST_PHONE", "moved_borders", "with_borders"]

LEAST_PHONE = 0.01
"""Seconds that a moved border leaves of a phone; one that was shorter keeps what it had."""
_TOLD = 1e-3
Floats = NDArray[np.float64]


def with_borders(layer: EditLayer, utterance: Utterance) -> tuple[Utterance, tuple[Lost, ...], tuple[Note, ...]]:
    """Lay the moved borders of a layer on an utterance; words and native phones go along.

    Returns
    -------
    utterance : Utterance
        The same one where nothing is moved.
    lost : tuple of Lost
    notes : tuple of Note
        Which borders could not go as far as asked.
    """
    places, wanted, lost = Places(layer, utterance), dict[int, float](), list[Lost]()
    for number, edit in layer.borders:
        try:
            border = places.border(edit.phone, edit.edge)
            wanted[border] = wanted.get(border, 0.0) + edit.shift
        except Gone as problem:
            lost.append(Lost(number, None, str(problem)))
    wanted = {border: shift for border, shift in wanted.items() if shift != 0}
    if not wanted:
        return utterance, tuple(lost), ()
    edges = np.array([phone.start for phone in utterance.phones] + [utterance.phones.intervals[-1].end])
    moved = moved_borders(edges, wanted)
    notes = []
    for border, shift in sorted(wanted.items()):
        short = edges[border] + shift - moved[border]
        if abs(short) > _TOLD:
            before, after = (utterance.phones.intervals[border + n].label for n in (-1, 0))
            told = f"the border between {before} and {after} at {edges[border]:.2f} s could not go {shift:+.3f} s"
            notes.append(Note("note", f"{told}: it went {moved[border] - edges[border]:+.3f} s, up to the next one"))
    return _warped(utterance, edges, moved), tuple(lost), tuple(notes)


def moved_borders(edges: Floats, shifts: Mapping[int, float]) -> Floats:
    """Borders after some are shifted; the others stay, and none comes nearer to another than `LEAST_PHONE`.

    The answer does not depend on the order of the shifts: where two would cross, the earlier border pushes the later.

    Parameters
    ----------
    edges : ndarray, shape (phones + 1,)
        Rising seconds; the first and the last stay.
    shifts : mapping of int to float
        Seconds, by number of the border.

    Examples
    --------
    >>> moved_borders(np.array([0.0, 0.1, 0.2, 0.3]), {1: 0.5, 2: 0.01}).round(3).tolist()
    [0.0, 0.28, 0.29, 0.3]
    """
    least = np.minimum(np.diff(edges), LEAST_PHONE)
    room = np.r_[0.0, np.cumsum(least)]  # what the phones up to a border need at least
    moved = edges.copy()
    still = np.array([border not in shifts for border in range(len(edges))])
    place = np.arange(len(edges))
    left = np.maximum.accumulate(np.where(still, place, 0))
    right = np.minimum.accumulate(np.where(still, place, len(edges) - 1)[::-1])[::-1]
    for border in sorted(shifts):
        low = edges[left[border]] + room[border] - room[left[border]]
        high = edges[right[border]] - (room[right[border]] - room[border])
        moved[border] = min(max(edges[border] + shifts[border], low), high)
        if not still[border - 1]:
            moved[border] = max(moved[border], moved[border - 1] + least[border - 1])
    return moved


def _warped(utterance: Utterance, edges: Floats, moved: Floats) -> Utterance:
    """All tiers with time bent so that the edges lie where they were moved to."""

    def bent(tier: Tier) -> Tier:
        starts = np.interp([one.start for one in tier], edges, moved) if len(tier) else np.zeros(0)
        ends = np.interp([one.end for one in tier], edges, moved) if len(tier) else np.zeros(0)
        return Tier(
            tier.name,
            tuple(Interval(float(a), float(max(a, b)), o.label) for a, b, o in zip(starts, ends, tier, strict=True)),
        )

    phones = tuple(
        Interval(float(start), float(end), phone.label)
        for start, end, phone in zip(moved[:-1], moved[1:], utterance.phones, strict=True)
    )
    native = None if utterance.native is None else bent(utterance.native)
    return replace(utterance, words=bent(utterance.words), phones=Tier(utterance.phones.name, phones), native=native)
