"""`EditLayer`: what was changed by hand, tied to words and phones rather than to seconds or frames."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

from mien.animation.edits.edited_line import Line
from mien.core import channels
from mien.core.errors import InputError, unknown_name
from mien.text.intensity import checked_intensity
from mien.text.key_tangents import check_tangents
from mien.text.parameter_curves import INTERPOLATIONS

__all__ = [
    "EMPTY",
    "MOST_DEGREES",
    "Anchor",
    "BorderEdit",
    "ChannelEdit",
    "EditLayer",
    "IntensityEdit",
    "Place",
    "channel_range",
]

MOST_DEGREES = 90.0
"""How far a hand may turn the head."""
_MOST_SHIFT = 60.0


def channel_range(channel: str) -> tuple[float, float]:
    """The least and the greatest value that an edited channel may have.

    Examples
    --------
    >>> channel_range("jawOpen"), channel_range("headYaw")
    ((0.0, 1.0), (-90.0, 90.0))
    """
    return (-MOST_DEGREES, MOST_DEGREES) if channel in channels.HEAD else (0.0, 1.0)


@dataclass(frozen=True)
class Place:
    """A phone of a word, or a pause after it.

    Attributes
    ----------
    word : str or None
        As in the words tier (lower case); None: before the first word, where there are only pauses. A take without
        words, such as one whose speech was not recognised, is all there.
    occurrence : int
        Which of the words of this name, from 1.
    index : int
        Which phone of the word, or which pause after it, from 0.
    pause : bool
        Whether it is a pause.
    """

    word: str | None
    occurrence: int = 1
    index: int = 0
    pause: bool = False

    def __post_init__(self) -> None:
        if self.occurrence < 1 or self.index < 0:
            raise InputError("words of a name count from 1, phones and pauses from 0")
        if self.word is None and (not self.pause or self.occurrence != 1):
            raise InputError("before the first word there are only pauses: give 'pause', not 'phone'")

    def __str__(self) -> str:
        which = "" if self.occurrence == 1 else f" ({self.occurrence}.)"
        word = "the first word" if self.word is None else f"{self.word!r}{which}"
        if self.pause:
            return f"pause {self.index} {'before' if self.word is None else 'after'} {word}"
        return f"phone {self.index} of {word}"


@dataclass(frozen=True)
class Anchor:
    """An instant: a share 0 (its start) to 1 (its end) of a phone or pause."""

    place: Place
    share: float = 0.0

    def __post_init__(self) -> None:
        if not 0 <= self.share <= 1:
            raise InputError(f"the share of a phone runs from 0 to 1, not {self.share:g}")


@dataclass(frozen=True)
class BorderEdit:
    """A border between two phones, moved.

    Attributes
    ----------
    phone : Place
    edge : {"start", "end"}
        Of that phone.
    shift : float
        Seconds against where it was found; later is positive.
    """

    phone: Place
    edge: Literal["start", "end"]
    shift: float

    def __post_init__(self) -> None:
        if self.edge not in ("start", "end"):
            raise InputError(f"an edge is 'start' or 'end', not {self.edge!r}")
        if not (math.isfinite(self.shift) and abs(self.shift) <= _MOST_SHIFT):
            raise InputError(f"a border is shifted by at most {_MOST_SHIFT:g} s, not {self.shift:g}")


Points = tuple[tuple[Anchor, float], ...]


@dataclass(frozen=True)
class IntensityEdit:
    """How strong an emotion is over the line; takes the place of all that was asked of that emotion.

    Attributes
    ----------
    emotion : str
    points : tuple of (Anchor, float)
        Intensities 0..1; the first and the last are held outwards.
    interpolation : {"linear", "smooth"}
        Between the points: straight lines, or a monotone cubic.
    tangents : tuple of str or None
        How the curve passes each point (`mien.text.key_tangents`); None, or empty: as ``interpolation`` has it.
    """

    emotion: str
    points: Points
    interpolation: Literal["linear", "smooth"] = "linear"
    tangents: tuple[str | None, ...] = ()

    def __post_init__(self) -> None:
        check_tangents(self.tangents, len(self.points))
        if not self.emotion or not self.points:
            raise InputError("an edit of an intensity names its emotion and has at least one point")
        if self.interpolation not in ("linear", "smooth"):
            raise unknown_name("interpolation", str(self.interpolation), ("linear", "smooth"))
        for _, value in self.points:
            checked_intensity(value)


@dataclass(frozen=True)
class ChannelEdit:
    """A curve drawn by hand over a channel.

    Attributes
    ----------
    channel : str
        One of `mien.core.channels.ALL`.
    mode : {"add", "replace"}
        Whether it is added to the motion, or takes its place from the first key to the last.
    keys : tuple of (Anchor, float)
        Weights, or degrees of the head. Added ones may be negative.
    fade : float
        Seconds before the first and after the last key over which it comes and goes.
    interpolation : {"smooth", "linear", "spline", "hold"}
        As of `mien.text.parameter_curves.ParameterCurve`.
    tangents : tuple of str or None
        As of `IntensityEdit`.
    """

    channel: str
    mode: Literal["add", "replace"]
    keys: Points
    fade: float = 0.1
    interpolation: str = "smooth"
    tangents: tuple[str | None, ...] = ()

    def __post_init__(self) -> None:
        check_tangents(self.tangents, len(self.keys))
        if self.channel not in channels.ALL:
            raise unknown_name("channel", self.channel, channels.ALL)
        if self.mode not in ("add", "replace"):
            raise unknown_name("mode", str(self.mode), ("add", "replace"))
        if self.interpolation not in INTERPOLATIONS:
            raise unknown_name("interpolation", self.interpolation, INTERPOLATIONS)
        if not self.keys:
            raise InputError(f"an edit of {self.channel} has at least one key")
        if not (math.isfinite(self.fade) and 0 <= self.fade <= _MOST_SHIFT):
            raise InputError(f"a fade lasts 0 to {_MOST_SHIFT:g} s, not {self.fade:g}")
        least, most = channel_range(self.channel)
        least = min(least, -most) if self.mode == "add" else least
        for _, value in self.keys:
            if not least <= value <= most:
                raise InputError(f"{self.channel} is {self.mode}ed by {least:g} to {most:g}, not {value:g}")


Edit = BorderEdit | IntensityEdit | ChannelEdit


@dataclass(frozen=True)
class EditLayer:
    """Edits, and the line on which they were made.

    Attributes
    ----------
    edits : tuple of BorderEdit, IntensityEdit or ChannelEdit
        In the order in which they are laid on; it matters only where two replace the same channel at one time.
    line : Line or None
        The words and phones that the edits speak of; None: those of whatever line they are laid on.
    emotions : tuple of str or None
        The emotions that were asked for when they were made; None: as ``line``.
    """

    edits: tuple[Edit, ...] = ()
    line: Line | None = None
    emotions: tuple[str, ...] | None = None

    @property
    def borders(self) -> tuple[tuple[int, BorderEdit], ...]:
        """The moved borders, with their places in `edits`."""
        return tuple((n, edit) for n, edit in enumerate(self.edits) if isinstance(edit, BorderEdit))

    @property
    def intensities(self) -> tuple[tuple[int, IntensityEdit], ...]:
        """The edited intensities, with their places in `edits`."""
        return tuple((n, edit) for n, edit in enumerate(self.edits) if isinstance(edit, IntensityEdit))

    @property
    def curves(self) -> tuple[tuple[int, ChannelEdit], ...]:
        """The edited channels, with their places in `edits`."""
        return tuple((n, edit) for n, edit in enumerate(self.edits) if isinstance(edit, ChannelEdit))

    def made_on(self, line: Line, emotions: tuple[str, ...]) -> EditLayer:
        """The same layer; what it does not say of the line on which it was made is this one's."""
        return replace(
            self,
            line=line if self.line is None else self.line,
            emotions=emotions if self.emotions is None else self.emotions,
        )


EMPTY = EditLayer()
"""No edit at all."""
