"""What the graph hears of an utterance: RASTA-PLP, brought to the same mean and spread in every utterance.

RASTA takes constant channels out; speakers still differ. Taking the mean and the deviation over the speech of an
utterance out of every coefficient brings recordings and another voice nearer to each other (Viikki, Laurila 1998), and
within one speaker costs nothing measurable.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mien.core.audio import Audio
from mien.core.time_spans import is_within
from mien.core.timeline import FrameRate, Tier
from mien.core.utterance import PAUSE
from mien.speech.rasta_plp import STEP, rasta_plp

__all__ = ["SOUND_RATE", "heard_features"]

SOUND_RATE = FrameRate.of(round(1 / STEP))
"""Frames of features per second; frame k stands at k / rate."""
_LEAST = 10  # frames of speech from which mean and spread are told; with fewer all frames are taken

Floats = NDArray[np.float64]


def heard_features(audio: Audio, phones: Tier) -> Floats:
    """Audio features of an utterance, shape (frames, 9), one every 10 ms.

    Parameters
    ----------
    audio : Audio
    phones : Tier
        Tells where speech is; pauses as ``SIL``.

    Examples
    --------
    >>> from mien.core.timeline import Interval
    >>> tone = Audio(0.1 * np.sin(np.arange(16000) * 0.3 * np.linspace(1, 2, 16000)), 16000)
    >>> values = heard_features(tone, Tier("phones", (Interval(0.0, 1.0, "AA"),)))
    >>> values.shape, bool(np.allclose(values[:-1].std(axis=0), 1, atol=0.1))
    ((101, 9), True)
    """
    values = rasta_plp(audio).values
    audio.rest()
    times = np.arange(len(values)) / SOUND_RATE.fps
    speech = is_within([phone for phone in phones if phone.label != PAUSE], times)
    told = values[speech] if speech.sum() >= _LEAST else values
    mean, spread = told.mean(axis=0), np.maximum(told.std(axis=0), 1e-3)
    del told
    values -= mean
    values /= spread
    return values
