"""What a recogniser hears of sound that is still coming in: log energies of mel bands, every 10 ms.

Row ``i`` is made of the 25 ms about ``i * HOP`` samples and of nothing else, however the sound is cut into pieces.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from mien.core.assets import asset

__all__ = ["BANDS", "HOP", "RATE", "WINDOW", "StreamingFeatures", "mel_bank"]

RATE, WINDOW, HOP = 16_000, 400, 160
BANDS = 80
_LEAST = 1e-10  # power

Single = NDArray[np.float32]


@cache
def mel_bank() -> Single:
    """The bands, shape (201, `BANDS`): those of the network that ours was learned from."""
    with asset("live/recogniser.npz").open("rb") as handle, np.load(handle, allow_pickle=False) as kept:
        return np.asarray(kept["mel"], np.float32)


@cache
def _window() -> Single:
    return np.hanning(WINDOW + 1)[:-1].astype(np.float32)


class StreamingFeatures:
    """Rows from samples that come in pieces.

    Parameters
    ----------
    bank : ndarray or None
        Of mel bands; None takes `mel_bank`.

    Examples
    --------
    >>> sound = np.random.default_rng(1).normal(0, 0.1, 4000)
    >>> whole, pieces = StreamingFeatures(), StreamingFeatures()
    >>> rows = whole.push(sound)
    >>> rows.shape
    (24, 80)
    >>> bool(np.allclose(rows, np.concatenate([pieces.push(part) for part in np.split(sound, 10)]), atol=1e-3))
    True
    """

    def __init__(self, bank: Single | None = None) -> None:
        self._bank = mel_bank() if bank is None else bank
        self._kept = np.zeros(WINDOW // 2, np.float32)

    def push(self, samples: NDArray[np.floating]) -> Single:
        """Take samples (16 kHz, -1..1) and give the rows that they complete, shape (rows, `BANDS`)."""
        held = np.concatenate([self._kept, np.asarray(samples, np.float32)])
        count = max(0, (len(held) - WINDOW) // HOP + 1)
        self._kept = held[count * HOP :]
        if not count:
            return np.zeros((0, BANDS), np.float32)
        windows = np.lib.stride_tricks.sliding_window_view(held, WINDOW)[: count * HOP : HOP]
        spectrum = np.fft.rfft(windows * _window())
        power = (spectrum.real**2 + spectrum.imag**2).astype(np.float32)
        return np.asarray(np.log(np.maximum(power @ self._bank, np.float32(_LEAST))))
