"""What a model of the speaking mouth is: phones in, markers out; some listen to the sound too."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from mien.core.audio import Audio
from mien.core.timeline import Tier

__all__ = ["HearingModel", "SpeechModel", "synthesise"]

Floats = NDArray[np.float64]


class SpeechModel(Protocol):
    """A fitted model that knows which markers it moves."""

    @property
    def markers_(self) -> tuple[str, ...]:
        """Names of the markers, in the order in which it gives them."""

    def synthesise(self, phones: Tier, times: Floats) -> Floats:
        """Positions of those markers at the given times, shape (frames, markers, 3), mm."""


@runtime_checkable
class HearingModel(Protocol):
    """A model that listens: with the sound it does better than with the phones alone."""

    def synthesise_heard(self, phones: Tier, times: Floats, audio: Audio) -> Floats:
        """As `SpeechModel.synthesise`; the phones' times are seconds from the start of the sound."""


class _Moves(Protocol):
    def synthesise(self, phones: Tier, times: Floats) -> Floats: ...


def synthesise(model: _Moves, phones: Tier, times: Floats, audio: Audio | None) -> Floats:
    """Let a model speak; one that listens gets the sound, the others are asked as ever."""
    if audio is not None and isinstance(model, HearingModel):
        return model.synthesise_heard(phones, times, audio)
    return model.synthesise(phones, times)
