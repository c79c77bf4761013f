"""Graphs of made-up recordings, for tests."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from mien.core.timeline import FrameRate, Interval, Tier
from mien.motion.graph.graph import AnimeGraph, RecordedChain, build_graph

MOTION, SOUND = FrameRate.of(25), FrameRate.of(100)


def said(*phones: tuple[str, float], start: float = 0.0) -> Tier:
    """Phones of given lengths, one after another."""
    edges = start + np.cumsum([0.0, *(length for _, length in phones)])
    return Tier(
        "phones",
        tuple(Interval(float(a), float(b), label) for a, b, (label, _) in zip(edges, edges[1:], phones, strict=False)),
    )


def chain(
    name: str, phones: Tier, motion: Callable[[NDArray[np.float64]], NDArray[np.float64]], seconds: float | None = None
) -> RecordedChain:
    """A take of one marker that moves as a function of time says; recorded up to ``seconds``."""
    end = phones.intervals[-1].end if seconds is None else seconds
    times = MOTION.times(MOTION.frames_covering(end) + 1)
    sound = np.arange(SOUND.frames_covering(phones.intervals[-1].end) + 1) / 100
    features = np.stack([np.sin(sound * (k + 1) * 9) for k in range(9)], axis=1)
    return RecordedChain(name, phones, "neutral", features, SOUND, motion(times), MOTION)


def graph(*chains: RecordedChain) -> AnimeGraph:
    return build_graph(chains, markers=1, instants=True)


def line(level: float, slope: float = 0.0) -> Callable[[NDArray[np.float64]], NDArray[np.float64]]:
    """Motion along x at a constant velocity."""
    return lambda times: np.stack([level + slope * times, 0 * times, 0 * times], axis=1)


def nodes_of(made: AnimeGraph, take: int) -> Sequence[int]:
    """Nodes of one take, in order."""
    return [int(node) for node in np.flatnonzero(made.take_of == take)]
