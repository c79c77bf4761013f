"""New motion out of recorded motion: patch-based sampling of a curve (Deng et al. 2006).

Liang et al. 2001 lay patches of a picture beside one another so that their borders agree; Deng et al. 2006 (Fig. 15) do
the same in one dimension, time: a patch of the source follows another if the few samples in which they overlap, the
boundary zone, are alike. Past the paper: velocities count in the match, and a patch that would merely go on
where the one before it ended is passed over while another one fits, so that the result is new.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError

__all__ = ["PatchSettings", "Patches", "sample_patches"]

_BLOCK = 4096
Floats = NDArray[np.float64]
Whole = NDArray[np.int64]


@dataclass(frozen=True)
class PatchSettings:
    """How patches are chosen; the paper's numbers at 120 samples per second are 30, 5 and 0.03.

    Attributes
    ----------
    patch, zone : int
        Samples of a patch, and of the boundary zone in which it overlaps its neighbour.
    tolerance : float
        A patch fits if the root mean square difference in the zone is below this share of the zone's own root mean
        square (Liang et al. 2001, Eq. 4).
    velocity : float
        Samples: how much a difference of 1 per sample in speed counts against a difference of 1 in place. 0: the
        paper's match, by place alone.
    fresh : bool
        Whether a patch that only continues its predecessor's recording is passed over while another fits. False is
        the paper's sampling, which copies most of a short source.
    """

    patch: int = 30
    zone: int = 5
    tolerance: float = 0.03
    velocity: float = 4.0
    fresh: bool = True

    def __post_init__(self) -> None:
        if not 0 < self.zone < self.patch or self.tolerance < 0 or self.velocity < 0:
            raise InputError(
                f"patches are longer than their zone, nothing is negative: not patch {self.patch}, zone {self.zone}, "
                f"tolerance {self.tolerance:g}, velocity {self.velocity:g}"
            )


@dataclass(frozen=True, eq=False)
class Patches:
    """Which source rows make the new curve: sample ``t`` is ``(1 - share) * source[before] + share * source[after]``.

    Attributes
    ----------
    before, after : ndarray of int, shape (samples,)
        Rows of all pieces of the source, one after the other. They differ in boundary zones only.
    share : ndarray, shape (samples,)
    joints : int
        How many patches follow another.
    stretched : int
        Joints at which no patch was within the tolerance, so the nearest was taken.
    copied : int
        Joints at which the patch goes on where the one before it ended: the source is copied there.
    """

    before: Whole
    after: Whole
    share: Floats
    joints: int
    stretched: int
    copied: int

    def of(self, source: Floats, part: slice = slice(None)) -> Floats:
        """The new curve, or a part of it, of anything known for every row of the source, shape (samples, ...)."""
        share, before, after = self.share[part], self.before[part], self.after[part]
        share = share.reshape(-1, *[1] * (source.ndim - 1))
        made = np.empty((len(share), *source.shape[1:]))
        for first in range(0, len(share), _BLOCK):  # an hour is long
            here = slice(first, first + _BLOCK)
            made[here] = (1 - share[here]) * source[before[here]] + share[here] * source[after[here]]
        return made


def sample_patches(
    pieces: Sequence[Floats], samples: int, random: np.random.Generator, settings: PatchSettings | None = None
) -> Patches:
    """Choose patches for a new curve. Never stuck: with no patch inside the tolerance the nearest one is taken.

    Parameters
    ----------
    pieces : sequence of ndarray, shape (rows, dimensions)
        The source: unbroken stretches, each at least a patch long.
    samples : int
        Length of the new curve, 1 or more.
    random : numpy.random.Generator
    settings : PatchSettings or None

    Raises
    ------
    InputError
        If no piece is as long as a patch, or nothing is asked for.

    Examples
    --------
    >>> wave = np.sin(np.arange(600) / 40)[:, None]
    >>> chosen = sample_patches([wave], 1000, np.random.default_rng(1))
    >>> bool(np.abs(np.diff(chosen.of(wave)[:, 0])).max() < 0.05)
    True
    """
    settings = settings or PatchSettings()
    if samples < 1:
        raise InputError(f"a curve has one sample or more, not {samples}")
    pieces = [np.asarray(piece, dtype=np.float64) for piece in pieces]
    offsets = np.cumsum([0, *map(len, pieces)])
    starts = np.concatenate(
        [np.arange(len(piece) - settings.patch + 1) + offset for piece, offset in zip(pieces, offsets, strict=False)]
        or [np.zeros(0)]
    ).astype(np.int64)
    starts = starts[starts >= 0]
    if not len(starts):
        longest = max(map(len, pieces), default=0)
        raise InputError(f"a source of patches of {settings.patch} samples is longer than {longest} samples")
    zones = _zones(pieces, settings)
    return _lay(zones, starts, samples, random, settings)


def _zones(pieces: Sequence[Floats], settings: PatchSettings) -> Floats:
    """Place and weighted speed of every row, shape (rows, 2 * dimensions)."""
    speed = np.concatenate([np.gradient(p, axis=0) if len(p) > 1 else np.zeros_like(p) for p in pieces])
    return np.concatenate([np.concatenate(pieces), settings.velocity * speed], axis=1)


def _lay(rows: Floats, starts: Whole, samples: int, random: np.random.Generator, settings: PatchSettings) -> Patches:
    patch, zone = settings.patch, settings.zone
    fade = np.arange(1, zone + 1) / (zone + 1)
    count = max(samples, patch)
    before, share = np.zeros(count + patch, dtype=np.int64), np.zeros(count + patch)
    after = before.copy()
    current = int(random.choice(starts))
    before[:patch] = after[:patch] = np.arange(current, current + patch)
    filled, joints, stretched, copied = patch, 0, 0, 0
    heads = rows[starts[:, None] + np.arange(zone)]  # (starts, zone, 2 * dimensions)
    while filled < count:
        tail = rows[np.arange(current + patch - zone, current + patch)]
        gaps = np.sqrt(((heads - tail) ** 2).sum(axis=2).mean(axis=1))
        limit = settings.tolerance * np.sqrt((tail[:, : rows.shape[1] // 2] ** 2).sum(axis=1).mean())
        going_on = current + patch - zone
        near = np.abs(starts - going_on) < (patch if settings.fresh else 0)
        fits = np.flatnonzero((gaps <= limit) & ~near)
        if not len(fits):
            fits = np.flatnonzero(gaps <= limit)
        if len(fits):
            chosen = int(starts[random.choice(fits)])
        else:
            others = np.flatnonzero(~near) if settings.fresh and not near.all() else np.arange(len(starts))
            chosen, stretched = int(starts[others[gaps[others].argmin()]]), stretched + 1
        joints, copied = joints + 1, copied + (chosen == going_on)
        place = filled - zone
        before[place:filled] = np.arange(going_on, going_on + zone)
        after[place : place + patch] = np.arange(chosen, chosen + patch)
        before[filled : place + patch] = after[filled : place + patch]
        share[place:filled] = fade
        filled, current = place + patch, chosen
    return Patches(before[:samples], after[:samples], share[:samples], joints, stretched, copied)
