"""`Animation`: what comes out of the pipeline, and the one lossless thing to keep."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib.metadata import version
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from mien.animation.edits.applied import AppliedEdits
from mien.core.audio import Audio
from mien.core.channels import ALL
from mien.core.errors import MissingPartError, Note
from mien.core.timeline import FrameRate, Interval, Tier
from mien.core.tracks import ChannelTrack, MarkerTrack
from mien.core.utterance import PAUSE, Utterance
from mien.text.score import Score

if TYPE_CHECKING:
    from pandas import DataFrame

__all__ = ["Animation", "Provenance", "at_rate", "imported"]


@dataclass(frozen=True)
class Provenance:
    """Where an animation came from, so that it can be made again bit for bit."""

    performer: str
    seed: int
    version: str


@dataclass(frozen=True)
class Animation:
    """A performance: channels (and markers, where the performer moves markers) over the sound.

    Attributes
    ----------
    channels : ChannelTrack
        The channels of `mien.core.channels.ALL`.
    markers : MarkerTrack or None
        The marker motion in millimetres, where the performer made one.
    utterance : Utterance
        The sound, words and phones it follows. Frame 0 stands at the start of the sound.
    score : Score
        The direction it follows.
    provenance : Provenance
    notes : tuple of Note
    edits : AppliedEdits or None
        The layer of edits that lies on it, and what was there before (``docs/edits.md``).
    timecode : str
        Of the first frame, ``HH:MM:SS:FF.mmm``, where the motion was recorded under one; else "".
    """

    channels: ChannelTrack
    markers: MarkerTrack | None
    utterance: Utterance
    score: Score
    provenance: Provenance
    notes: tuple[Note, ...] = ()
    edits: AppliedEdits | None = None
    timecode: str = ""
    html_of: ClassVar[Callable[[Animation], str] | None] = None
    """What shows an animation in a notebook; the room that has faces and formats sets it (`mien.api.notebook`)."""

    def to_frame(self) -> DataFrame:
        """The channels as a pandas DataFrame: a row for each frame, its seconds as index, a column for each channel.

        Weights are 0 to 1, angles of the head degrees.

        Raises
        ------
        MissingPartError
            If pandas is not installed.
        """
        try:
            from pandas import DataFrame, Index
        except ImportError as problem:
            raise MissingPartError("a table needs pandas: pip install pandas") from problem
        seconds = self.rate.times(len(self.channels))
        return DataFrame(self.channels.values, Index(seconds, name="seconds"), columns=list(self.channels.names))

    def _repr_html_(self) -> str | None:
        return None if Animation.html_of is None else Animation.html_of(self)

    @property
    def rate(self) -> FrameRate:
        """Frame rate of the channels."""
        return self.channels.rate


def imported(channels: ChannelTrack, name: str, notes: tuple[Note, ...] = (), timecode: str = "") -> Animation:
    """Motion from elsewhere as an animation, over silence: what is said in it is not known.

    Parameters
    ----------
    channels : ChannelTrack
        Some of `mien.core.channels.ALL`; the others rest.
    name : str
        Where it comes from.
    notes : tuple of Note
        What was said when it was read.
    timecode : str
        Of the first frame; "" if it has none.
    """
    seconds = len(channels) / channels.rate.fps
    pause = Tier("phones", (Interval(0.0, seconds, PAUSE),))
    silence = Utterance("", Audio.silence(seconds, 16_000), Tier("words", ()), pause, "und", "none")
    track = channels.select(ALL)
    origin = Provenance(f"imported from {name}", 0, version("mien"))
    return Animation(track, None, silence, Score(), origin, notes, timecode=timecode)


def at_rate(animation: Animation, rate: FrameRate) -> Animation:
    """An animation at another frame rate: straight lines between its frames.

    A layer of edits becomes part of the motion, and a note says so.

    Examples
    --------
    >>> import numpy as np
    >>> slow = imported(ChannelTrack(("jawOpen",), np.linspace(0, 1, 26)[:, None], FrameRate.of(25)), "a test")
    >>> at_rate(slow, FrameRate.of(50)).channels.channel("jawOpen")[:4].round(2).tolist()
    [0.0, 0.02, 0.04, 0.06]
    """
    if rate == animation.rate:
        return animation
    track, markers = animation.channels, animation.markers
    frames = rate.frames_covering(len(track) / track.rate.fps)
    now, then = rate.times(frames), track.rate.times(len(track))
    values = np.stack([np.interp(now, then, column) for column in track.values.T], axis=1)
    if markers is not None:
        flat = markers.positions.reshape(len(markers), -1)
        moved = np.stack([np.interp(now, then, column) for column in flat.T], axis=1)
        markers = MarkerTrack(markers.names, moved.reshape(frames, *markers.positions.shape[1:]), rate)
    notes = animation.notes
    if animation.edits is not None:
        notes += (Note("note", "the edits by hand are part of the motion now: it was brought to another frame rate"),)
    channels = ChannelTrack(track.names, values, rate)
    return replace(animation, channels=channels, markers=markers, notes=notes, edits=None)
