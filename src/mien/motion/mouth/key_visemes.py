"""Key shapes taken from recordings on their own (the future work of Deng et al. 2006, section VIII).

The key shape of a class of phones is the geometric median of their samples: the pose with the least sum of distances to
all of them, which a few badly aligned samples hardly move.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from mien.core.utterance import PAUSE
from mien.motion.mouth.articulation import articulation_table
from mien.motion.mouth.phone_samples import SampledUtterance

__all__ = ["geometric_median", "key_shapes"]

Floats = NDArray[np.float64]


def geometric_median(points: Floats, steps: int = 100, tolerance: float = 1e-9) -> Floats:
    """Point with the least sum of distances to ``points``, shape (points, dimensions) (Weiszfeld's iteration).

    Examples
    --------
    >>> geometric_median(np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [100.0, 100.0]])).round(3).tolist()
    [1.0, 1.0]
    """
    centre: Floats = np.median(points, axis=0)
    scale = float(np.abs(points - centre).mean()) or 1.0
    for _ in range(steps):
        nearness = 1 / np.maximum(np.linalg.norm(points - centre, axis=1), 1e-9 * scale)
        moved: Floats = (nearness[:, None] * points).sum(axis=0) / nearness.sum()
        step = float(np.linalg.norm(moved - centre))
        centre = moved
        if step <= tolerance * scale:
            break
    return centre


def key_shapes(
    utterances: Sequence[SampledUtterance], per_phone: bool, least: int = 3, given: Mapping[str, Floats] | None = None
) -> dict[str, Floats]:
    """Key shape of each of the 39 phones and of the pause, in pose components.

    Parameters
    ----------
    utterances : sequence of SampledUtterance
    per_phone : bool
        Whether a phone with at least ``least`` samples has a key of its own; else all phones of a class share one.
    least : int
    given : mapping of str to ndarray, or None
        Keys by viseme class (or ``SIL``) that were made by hand; they go before those found.

    Returns
    -------
    dict of str to ndarray, shape (components,)
        A phone whose class was never recorded has the mean pose (zeros).
    """
    table = articulation_table()
    met: dict[str, list[Floats]] = {phone: [] for phone in table.parts}
    for said in utterances:
        for label, frame in zip(said.labels, said.middles, strict=True):
            met[label].append(said.poses[frame])
    components = utterances[0].poses.shape[1]
    keys: dict[str, Floats] = {}
    for name, members in [*table.visemes.items(), (PAUSE, (PAUSE,))]:
        samples = [sample for phone in members for sample in met[phone]]
        shared = geometric_median(np.array(samples)) if samples else np.zeros(components)
        for phone in members:
            own = per_phone and len(met[phone]) >= least
            keys[phone] = geometric_median(np.array(met[phone])) if own else shared
            if given and name in given:
                keys[phone] = np.asarray(given[name], dtype=np.float64)
    return keys
