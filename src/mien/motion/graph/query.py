"""What is looked for in the Anime Graph: the phones of new speech with their sound, length and emotion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.core.timeline import FrameRate, Tier
from mien.motion.graph.graph import frame_spans, without_gaps

__all__ = ["SpokenPhones", "spoken_phones"]


@dataclass(frozen=True, eq=False)
class SpokenPhones:
    """Phones in the order in which they are spoken.

    Attributes
    ----------
    phones : tuple of str
    features : tuple of ndarray of float32, shapes (frames, coefficients)
        Audio features of each phone, as those of the graph; at least one frame.
    durations : tuple of float
        Seconds.
    emotions : tuple of str, or None
        Label of each phone; None leaves the emotion open.
    """

    phones: tuple[str, ...]
    features: tuple[NDArray[np.float32], ...]
    durations: tuple[float, ...]
    emotions: tuple[str, ...] | None = None

    def __post_init__(self) -> None:
        counts = {len(self.phones), len(self.features), len(self.durations), len(self.emotions or self.phones)}
        if len(counts) > 1:
            raise InputError(
                f"each of the {len(self.phones)} phones has features, a duration and perhaps an emotion, not "
                f"{len(self.features)}, {len(self.durations)} and {len(self.emotions or ())} of them"
            )
        for phone, rows in zip(self.phones, self.features, strict=True):
            if rows.ndim != 2 or not len(rows) or not np.isfinite(rows).all():
                raise InputError(f"the features of phone {phone!r} must be finite, (frames, coefficients), not empty")

    def __len__(self) -> int:
        return len(self.phones)

    def part(self, first: int, after: int) -> SpokenPhones:
        """Phones ``first`` up to and without ``after``."""
        kept = slice(first, after)
        emotions = self.emotions[kept] if self.emotions is not None else None
        return SpokenPhones(self.phones[kept], self.features[kept], self.durations[kept], emotions)


def spoken_phones(
    phones: Tier,
    features: NDArray[Any],
    rate: FrameRate,
    emotion: str | Sequence[str] | None = None,
) -> SpokenPhones:
    """Cut the features of an utterance by its phones.

    Parameters
    ----------
    phones : Tier
        Seconds from the start of the sound; gaps become pauses.
    features : ndarray, shape (frames, coefficients)
        Frame ``k`` stands at ``k / rate``.
    rate : FrameRate
    emotion : str, sequence of str, or None
        One label for all phones, one for each (pauses in gaps counted), or none.

    Examples
    --------
    >>> from mien.core.timeline import Interval
    >>> tier = Tier("phones", (Interval(0.0, 0.2, "AY"), Interval(0.2, 0.3, "M")))
    >>> asked = spoken_phones(tier, np.zeros((30, 9)), FrameRate.of(100), "happy")
    >>> [len(rows) for rows in asked.features], asked.emotions
    ([20, 10], ('happy', 'happy'))
    """
    phones = without_gaps(phones)
    spans = frame_spans(phones, rate, len(features)) if len(phones) else np.empty((0, 2), dtype=np.int64)
    emotions = (emotion,) * len(phones) if isinstance(emotion, str) else emotion
    return SpokenPhones(
        tuple(phone.label for phone in phones),
        tuple(np.asarray(features[first : first + count], dtype=np.float32) for first, count in spans),
        tuple(phone.duration for phone in phones),
        tuple(emotions) if emotions is not None else None,
    )
