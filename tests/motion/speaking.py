"""Made-up recordings with a known answer, for tests of the learned mouth."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mien.core.audio import Audio
from mien.core.timeline import FrameRate, Interval, Tier
from mien.core.tracks import MarkerTrack
from mien.corpus.take import Take
from mien.motion.mouth.articulation import articulation_table, parts_of

NAMES = ("2.2", "2.3", "8.1", "8.2", "8.3", "8.4", "2.4", "2.5", "mp_082", "mp_087", "2.1", "mp_400")
"""Twelve mouth markers of the layout mediapipe-218."""
REST = np.array(
    [[0, 0, 8], [0, -0.3, 8], [0, 5, 9], [0, -6, 9], [24, 0, 0], [-24, 0, 0], [21, 0, 0], [-21, 0, 0], [-3, 0, 8],
     [-3, -0.3, 8], [0, -35, 5], [10, -33, 3]], dtype=float,
)  # fmt: skip
OPEN = np.array([[0, y, 0] for y in (0.2, -0.8, 0.15, -0.85, -0.1, -0.1, -0.1, -0.1, 0.2, -0.8, -0.9, -0.8)])
NARROW = np.array(
    [[0, 0, 1]] * 4 + [[-1, 0, 0], [1, 0, 0], [-1, 0, 0], [1, 0, 0]] + [[0, 0, 1]] * 2 + [[0, 0, 0]] * 2, dtype=float
)


def tier(labels: Sequence[str], duration: float = 0.1, start: float = 0.0) -> Tier:
    """Phones of one length each."""
    edges = start + duration * np.arange(len(labels) + 1)
    return Tier(
        "phones", tuple(Interval(float(a), float(b), x) for a, b, x in zip(edges, edges[1:], labels, strict=False))
    )


def wanted_opening_and_rounding(labels: Sequence[str]) -> NDArray[np.float64]:
    """What the made-up speaker aims at in each part: shape (parts, 2), mm."""
    table = articulation_table()
    values = table.values[[part for label in labels for part in table.parts[label]]]
    column = {name: values[:, place] for place, name in enumerate(table.features)}
    opening = 3 + 9 * column["open"] - 3 * column["pause"] - 3 * column["bilabial"] - column["labiodental"]
    return np.stack([opening, 5 * column["round"]], axis=1)


def mouth(opening: NDArray[np.float64], rounding: NDArray[np.float64]) -> NDArray[np.float64]:
    """Marker positions, shape (frames, 12, 3)."""
    return REST + opening[:, None, None] * OPEN + rounding[:, None, None] * NARROW


def take(name: str, phones: Tier, fps: float = 50.0, noise: float = 0.0, seed: int = 0) -> Take:
    """A take in which the mouth passes smoothly through the aims of its phones."""
    parts = parts_of(phones)
    rate = FrameRate.of(fps)
    times = rate.times(rate.frames_covering(phones.intervals[-1].end))
    aims = wanted_opening_and_rounding([p.label for p in phones])
    middles = (parts.starts + parts.ends) / 2
    place = np.interp(times, middles, np.arange(len(middles)))
    low = np.minimum(place.astype(int), len(middles) - 2)
    share = ((1 - np.cos(np.pi * (place - low))) / 2)[:, None]
    aim = aims[low] * (1 - share) + aims[low + 1] * share
    positions = mouth(aim[:, 0], aim[:, 1]) + noise * np.random.default_rng(seed).standard_normal((len(times), 12, 3))
    words = Tier("words", (Interval(0.0, phones.intervals[-1].end, name.partition("-")[0]),))
    return Take(
        name,
        Audio.silence(float(times[-1]) + 0.02, 8000),
        MarkerTrack(NAMES, positions, rate),
        name,
        words,
        phones,
        "mediapipe-218",
    )


def takes(count: int = 30, seed: int = 0, noise: float = 0.05) -> list[Take]:
    """Random strings of phones between pauses; ``OY`` and ``ZH`` are never said."""
    random = np.random.default_rng(seed)
    phones = [phone for phone in articulation_table().parts if phone not in ("SIL", "OY", "ZH")]
    made = []
    for number in range(count):
        labels = ["SIL", *random.choice(phones, 14).tolist(), "SIL"]
        made.append(
            take(
                f"word{number % 5}-{number}", tier(labels, float(random.uniform(0.07, 0.13))), noise=noise, seed=number
            )
        )
    return made
