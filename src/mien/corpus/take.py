"""`Take`: one recorded utterance, its sound and its face motion on one clock."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mien.core.audio import Audio
from mien.core.errors import InputError
from mien.core.timeline import Tier
from mien.core.tracks import ChannelTrack, MarkerTrack

__all__ = ["Take"]


@dataclass(frozen=True, eq=False)
class Take:
    """One recorded utterance.

    Attributes
    ----------
    name : str
        Unique in its corpus; letters, digits, ``_``, ``-`` and ``.`` only, as it names files.
    audio : Audio
    markers : MarkerTrack
        Cleaned and normalised (Deng et al. 2006): millimetres, x to the speaker's left, y up, z forward, the head's
        own motion taken out. Frame 0 stands at the start of the sound.
    head : ndarray, shape (frames, 4, 4), or None
        The rigid motion of the head that was taken out: maps normalised to recorded positions (mm, columns).
    text : str
    words, phones : Tier
        Seconds from the start of the sound; phones are ARPAbet without stress, pauses as ``SIL``.
    layout : str
        Name of the marker layout (``assets/markers``).
    emotion : str
    sentence : str
        Takes with the same value say the same sentence ("same sentence" links).
    speaker : str
    source : dict of str
        Where the take came from: file, recipe, and what was repaired.
    channels : ChannelTrack or None
        Weights of the speaker's own face, frame by frame with the markers: as recorded by face capture, else captured
        from the markers (`mien.corpus.capturing`); None where neither was done.
    captured : bool
        Whether the channels were captured from the markers, and not recorded.
    """

    name: str
    audio: Audio
    markers: MarkerTrack
    text: str
    words: Tier
    phones: Tier
    layout: str
    head: NDArray[np.float64] | None = None
    emotion: str = "neutral"
    sentence: str = ""
    speaker: str = ""
    source: dict[str, str] = field(default_factory=dict)
    channels: ChannelTrack | None = None
    captured: bool = False

    def __post_init__(self) -> None:
        if not self.name or not all(c.isalnum() or c in "_-." for c in self.name) or self.name.startswith("."):
            raise InputError(f"a take's name has letters, digits, '_', '-' and '.' only, not {self.name!r}")

    @property
    def duration(self) -> float:
        """Seconds of sound."""
        return self.audio.duration
