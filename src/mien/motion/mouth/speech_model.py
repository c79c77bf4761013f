"""What a model of the speaking mouth is: phones in, the mouth in motion out; some listen to the sound too."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from mien.core.audio import Audio
from mien.core.timeline import Tier
from mien.motion.mouth.mouth_space import MouthSpace

__all__ = ["HearingModel", "SpeechModel", "synthesise"]

Floats = NDArray[np.float64]


class SpeechModel(Protocol):
    """A fitted model that knows what it moves."""

    @property
    def mouth_(self) -> MouthSpace:
        """Channels or markers, in the order in which it gives them."""

    def synthesise(self, phones: Tier, times: Floats) -> Floats:
        """Weights (frames, channels), 0..1, or positions (frames, markers, 3), mm, at the given times."""


@runtime_checkable
class HearingModel(Protocol):
    """A model that listens: with the sound it does better than with the phones alone."""

    def synthesise_heard(self, phones: Tier, times: Floats, audio: Audio, felt: Tier | None = None) -> Floats:
        """As `SpeechModel.synthesise`; the phones' times are seconds from the start of the sound.

        ``felt``: where which emotion is asked for; elsewhere, and if None, neutral speech.
        """


class _Moves(Protocol):
    def synthesise(self, phones: Tier, times: Floats) -> Floats: ...


def synthesise(model: _Moves, phones: Tier, times: Floats, audio: Audio | None, felt: Tier | None = None) -> Floats:
    """Let a model speak; one that listens gets the sound, the others are asked as ever."""
    if audio is not None and isinstance(model, HearingModel):
        return model.synthesise_heard(phones, times, audio, felt)
    return model.synthesise(phones, times)
