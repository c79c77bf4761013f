"""`Animation`: what comes out of the pipeline, and the one lossless thing to keep."""

from __future__ import annotations

from dataclasses import dataclass

from mien.errors import Note
from mien.script.score import Score
from mien.speech.utterance import Utterance
from mien.timeline import FrameRate
from mien.tracks import ChannelTrack, MarkerTrack

__all__ = ["Animation", "Provenance"]


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
        The channels of `mien.channels.ALL`.
    markers : MarkerTrack or None
        The marker motion in millimetres, where the performer made one.
    utterance : Utterance
        The sound, words and phones it follows. Frame 0 stands at the start of the sound.
    score : Score
        The direction it follows.
    provenance : Provenance
    notes : tuple of Note
    """

    channels: ChannelTrack
    markers: MarkerTrack | None
    utterance: Utterance
    score: Score
    provenance: Provenance
    notes: tuple[Note, ...] = ()

    @property
    def rate(self) -> FrameRate:
        """Frame rate of the channels."""
        return self.channels.rate
