"""Between the numbers of a picture (sRGB) and amounts of light (linear), and the tone curve of the renderer.

sRGB: IEC 61966-2-1. The tone curve is a straight line up to `KNEE` and a soft shoulder above it that nears 1:
``KNEE + (1 - KNEE) s / (1 + s)`` with ``s = (light - KNEE) / (1 - KNEE)``; it is smooth at the knee.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["KNEE", "SRGB_BYTES", "SRGB_STEPS", "linear_from_srgb", "tone"]

KNEE = 0.55
SRGB_STEPS = 4096


def linear_from_srgb(values: ArrayLike) -> NDArray[np.float32]:
    """Linear light 0..1 of sRGB numbers 0..1.

    Examples
    --------
    >>> linear_from_srgb([0.0, 0.5, 1.0]).round(4).tolist()
    [0.0, 0.21400000154972076, 1.0]
    """
    v = np.asarray(values, dtype=np.float64)
    return np.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4).astype(np.float32)


def tone(light: NDArray[np.float32]) -> NDArray[np.float32]:
    """Bring linear light 0.. into 0..1 (formula above)."""
    s = np.maximum(light - KNEE, 0) / (1 - KNEE)
    return np.asarray(np.minimum(light, KNEE) + (1 - KNEE) * s / (1 + s), dtype=np.float32)


def _srgb_table() -> NDArray[np.float32]:
    """SRGB number 0..255 (not yet rounded) of linear light; entry i holds light (i / (SRGB_STEPS - 1)) ** 2."""
    light = (np.arange(SRGB_STEPS) / (SRGB_STEPS - 1)) ** 2
    srgb = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    return (255 * srgb).astype(np.float32)


SRGB_BYTES = _srgb_table()
