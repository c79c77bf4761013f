"""Algorithm 1 of Deng et al. 2006 written down plainly, one frame at a time: the referee of `coarticulation`.

Follows the paper's listing: the motion grows piece by piece, a triphone after a triphone is blended with the end of
what is there. Slow on purpose; tests only.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mien.core.timeline import Tier
from mien.motion.mouth.articulation import articulation_table
from mien.motion.mouth.coarticulation import Coarticulation

__all__ = ["synthesise_plainly"]

Floats = NDArray[np.float64]


def synthesise_plainly(model: Coarticulation, phones: Tier, times: Floats) -> Floats:
    """What ``model.synthesise(phones, times)`` must give, shape (frames, markers, 3), mm.

    Agrees to 1e-12 of the key shapes' size, not to the bit: powers and cosines of one number and of an array may be
    rounded differently, and the final change from components to markers sums in another order.
    """
    labels = [phone.label for phone in phones]
    middles = [phone.middle for phone in phones]
    motion: dict[int, Floats] = {}
    after_triphone = False
    i = 0
    while i < len(labels) - 1:
        if i + 2 < len(labels) and tuple(labels[i : i + 3]) in model.curves_:
            piece = _piece(model, labels, middles, times, i, 3)
            for frame, pose in piece.items():
                if after_triphone and frame in motion:
                    motion[frame] = _blend(
                        model, motion[frame], pose, (times[frame] - middles[i]) / (middles[i + 1] - middles[i])
                    )
                else:
                    motion[frame] = pose
            after_triphone = True
        elif after_triphone:
            after_triphone = False
        else:
            motion.update(_piece(model, labels, middles, times, i, 2))
        i += 1
    for frame, time in enumerate(times):
        if time < middles[0]:
            motion[frame] = model.keys_[labels[0]]
        elif time >= middles[-1]:
            motion[frame] = model.keys_[labels[-1]]
    poses = np.array([motion[frame] for frame in range(len(times))])
    return model.space_.decode(poses).reshape(len(times), -1, 3)


def _piece(
    model: Coarticulation, labels: list[str], middles: list[float], times: Floats, first: int, count: int
) -> dict[int, Floats]:
    """Poses of the frames between the first and the last of ``count`` phones, by frame."""
    start, end = middles[first], middles[first + count - 1]
    said = tuple(labels[first : first + count])
    piece: dict[int, Floats] = {}
    for frame, time in enumerate(times):
        if start <= time < end:
            weights = _weights(model, said, float((time - start) / (end - start)))
            pose = np.zeros(model.settings.components)
            for weight, phone in zip(weights, said, strict=True):
                pose = pose + weight * model.keys_[phone]
            piece[frame] = pose
    return piece


def _weights(model: Coarticulation, said: tuple[str, ...], t: float) -> list[float]:
    viseme = articulation_table().viseme_of
    curves = model.curves_.get(said) or model.class_curves_.get(tuple(viseme(phone) for phone in said))
    if curves is None:
        rising = (1 - math.cos(math.pi * t)) / 2
        return [1 - rising, rising]
    return [sum(float(c) * t**power for power, c in enumerate(column)) for column in curves.coefficients.T]


def _blend(model: Coarticulation, earlier: Floats, later: Floats, t: float) -> Floats:
    mu, n = model.settings.blend_mu, model.settings.blend_n
    falling = mu * (1 - t) ** (n + 1)
    weight = falling / (falling + (1 - mu) * t ** (n + 1))
    return np.asarray(weight * earlier + (1 - weight) * later)
