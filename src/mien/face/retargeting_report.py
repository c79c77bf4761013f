"""What a rig cannot do of a motion, by region of the face; and which of its shapes markers cannot tell apart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError

__all__ = ["AmbiguousChannel", "RegionResidual", "ambiguous_channels", "residual_by_region"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class RegionResidual:
    """How much of a region's motion a rig shows.

    Attributes
    ----------
    region : str
    markers : int
    asked, missed : float
        Root mean square over frames and markers of the motion asked for, and of what is left over, mm.
    missed_95 : float
        What 95 of 100 markers and frames stay below, mm.
    across, up, forward : float
        The left over motion along the face's axes, mm RMS.
    worst : str
        The marker that misses most, and by how much.
    worst_missed : float
        Its RMS, mm.
    """

    region: str
    markers: int
    asked: float
    missed: float
    missed_95: float
    across: float
    up: float
    forward: float
    worst: str
    worst_missed: float

    def line(self) -> str:
        """The same in words."""
        axis = max(
            (("sideways", self.across), ("up and down", self.up), ("in depth", self.forward)), key=lambda a: a[1]
        )
        share = self.missed / self.asked if self.asked > 0 else 0.0
        return (
            f"{self.region}: {self.missed:.2f} mm of {self.asked:.2f} mm not reached ({share:.0%}), "
            f"most of it {axis[0]}; 95 % below {self.missed_95:.2f} mm; worst {self.worst} ({self.worst_missed:.2f} mm)"
        )


def residual_by_region(
    asked: Floats, reached: Floats, markers: Sequence[str], regions: Mapping[str, Sequence[str]]
) -> tuple[RegionResidual, ...]:
    """Compare asked and reached displacements, both (frames, markers, 3) in mm, region by region.

    Parameters
    ----------
    asked, reached : ndarray, shape (frames, markers, 3)
    markers : sequence of str
    regions : mapping of str to sequence of str
        Markers of each region; those that there are not are passed over.

    Raises
    ------
    InputError
        If the shapes do not fit.

    Examples
    --------
    >>> asked = np.zeros((2, 2, 3)); asked[1, 0, 1] = 4.0
    >>> told = residual_by_region(asked, asked / 2, ["chin", "brow"], {"jaw": ["chin"]})
    >>> told[0].line()
    'jaw: 1.41 mm of 2.83 mm not reached (50%), most of it up and down; 95 % below 1.90 mm; worst chin (1.41 mm)'
    """
    if asked.shape != reached.shape or asked.ndim != 3 or asked.shape[1:] != (len(markers), 3):
        raise InputError(f"expected twice (frames, {len(markers)} markers, 3), got {asked.shape} and {reached.shape}")
    place = {name: number for number, name in enumerate(markers)}
    result = []
    for region, members in regions.items():
        columns = [place[name] for name in members if name in place]
        if not columns or not len(asked):
            continue
        left = asked[:, columns] - reached[:, columns]
        far = np.linalg.norm(left, axis=2)
        by_marker = np.sqrt((far**2).mean(axis=0))
        axes = np.sqrt((left**2).mean(axis=(0, 1)))
        result.append(
            RegionResidual(
                region=region,
                markers=len(columns),
                asked=_rms(np.linalg.norm(asked[:, columns], axis=2)),
                missed=_rms(far),
                missed_95=float(np.percentile(far, 95)),
                across=float(axes[0]),
                up=float(axes[1]),
                forward=float(axes[2]),
                worst=markers[columns[int(by_marker.argmax())]],
                worst_missed=float(by_marker.max()),
            )
        )
    return tuple(result)


def _rms(values: Floats) -> float:
    return float(np.sqrt((values**2).mean()))


@dataclass(frozen=True)
class AmbiguousChannel:
    """A channel whose motion at the markers others can nearly make.

    Attributes
    ----------
    channel : str
    own : float
        Share of its length that no mixture of the others makes, 0..1.
    stand_ins : tuple of str
        The channels that do most of it.
    """

    channel: str
    own: float
    stand_ins: tuple[str, ...]


def ambiguous_channels(basis: Floats, channels: Sequence[str], below: float = 0.1) -> tuple[AmbiguousChannel, ...]:
    """Channels that markers can hardly tell from mixtures of others.

    Parameters
    ----------
    basis : ndarray, shape (channels, markers, 3)
    channels : sequence of str
    below : float
        Share of a channel's own motion from which on it counts as told apart.

    Examples
    --------
    >>> basis = np.zeros((3, 2, 3)); basis[0, 0, 0] = 1; basis[1, 1, 1] = 1; basis[2] = basis[0] + basis[1]
    >>> [found.channel for found in ambiguous_channels(basis, ["a", "b", "both"])]
    ['a', 'b', 'both']
    """
    flat = basis.reshape(len(basis), -1)
    found = []
    for row, name in enumerate(channels):
        length = float(np.linalg.norm(flat[row]))
        if length == 0:
            found.append(AmbiguousChannel(name, 0.0, ()))
            continue
        others = np.delete(flat, row, axis=0)
        shares = np.linalg.lstsq(others.T, flat[row], rcond=1e-10)[0] if len(others) else np.zeros(0)
        own = float(np.linalg.norm(flat[row] - shares @ others)) / length
        if own < below:
            names = [other for other in channels if other != name]
            sizes = np.abs(shares) * np.linalg.norm(others, axis=1)
            most = np.argsort(-sizes, kind="stable")[:3]
            found.append(AmbiguousChannel(name, own, tuple(names[m] for m in most if sizes[m] > 0.1 * length)))
    return tuple(found)
