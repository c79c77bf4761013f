"""Numbers in small whole steps: a graph takes a quarter of the room, and a file gives the same bits back.

What is learned is snapped to the steps at once, before it is used, so that a model that was saved and loaded moves as
it did before, to the bit.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.motion.graph.graph import AnimeGraph

__all__ = ["FEATURE_STEP", "packed", "snapped", "snapped_graph", "steps_for", "unpacked"]

FEATURE_STEP = 1 / 32
"""Audio features have deviation 1: eight bits hold them to 4 deviations, in steps of 1/32."""

Floats32 = NDArray[np.float32]


def steps_for(values: NDArray[Any], kind: type[np.int8] | type[np.int16]) -> Floats32:
    """Least steps with which whole numbers of a kind hold each column (last axis) of finite values."""
    flat = np.abs(values.reshape(-1, values.shape[-1]))
    most = np.nanmax(np.where(np.isfinite(flat), flat, 0.0), axis=0, initial=0.0)
    return np.asarray(np.maximum(most / np.iinfo(kind).max, 1e-9), dtype=np.float32)


def packed(
    values: NDArray[Any], steps: Floats32, kind: type[np.int8] | type[np.int16]
) -> NDArray[np.int8] | NDArray[np.int16]:
    """Values as whole numbers of steps; what is not finite as the least whole number, which nothing else is.

    Examples
    --------
    >>> packed(np.array([[0.5], [np.nan], [-9.0]]), np.float32([0.25]), np.int8).ravel().tolist()
    [2, -128, -36]
    """
    limits = np.iinfo(kind)
    numbers = np.clip(np.rint(np.nan_to_num(values) / steps), -limits.max, limits.max).astype(kind)
    return np.where(np.isfinite(values), numbers, kind(limits.min))


def unpacked(numbers: NDArray[Any], steps: Floats32) -> Floats32:
    """The way back.

    Examples
    --------
    >>> unpacked(np.int8([[2], [-128]]), np.float32([0.25])).ravel().tolist()
    [0.5, nan]
    """
    values: Floats32 = numbers.astype(np.float32) * steps
    values[numbers == np.iinfo(numbers.dtype).min] = np.nan
    return values


def snapped(values: NDArray[Any], steps: Floats32, kind: type[np.int8] | type[np.int16]) -> Floats32:
    """Values rounded to the steps."""
    return unpacked(packed(values, steps, kind), steps)


def snapped_graph(graph: AnimeGraph) -> tuple[AnimeGraph, Floats32]:
    """A graph with motion, poses and features rounded to steps, and the steps of its motion and poses."""
    poses = np.concatenate([graph.motion, graph.entries, graph.exits])
    steps = steps_for(poses, np.int16)
    heard = np.full(graph.features.shape[1], FEATURE_STEP, dtype=np.float32)
    moves: dict[str, Any] = {
        name: snapped(getattr(graph, name), steps, np.int16) for name in ("motion", "entries", "exits")
    }
    return replace(graph, features=snapped(graph.features, heard, np.int8), **moves), steps
