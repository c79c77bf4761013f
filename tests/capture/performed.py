"""Markers of a face that performs known channels, as a tracker sees it."""

from __future__ import annotations

from functools import cache

import numpy as np

from mien.capture.layouts import Layout, load_layout
from mien.core.channels import WEIGHTS
from mien.core.timeline import FrameRate
from mien.core.tracks import MarkerTrack
from mien.face.library import load_face
from mien.face.marker_sites import place_markers
from mien.face.retargeting import basis_at

FRAMES = 60
RATE = FrameRate.of(25)


@cache
def basis(layout: str) -> np.ndarray:
    """What every weight does to the markers of the default face, (channels, markers, 3) mm."""
    return basis_at(load_face("default"), place_markers(load_face("default"), load_layout(layout)).sites, WEIGHTS)


def swell(height: float) -> np.ndarray:
    """From rest to a height and back, with rest before and after."""
    curve = np.zeros(FRAMES)
    curve[10:-10] = height * np.sin(np.linspace(0, np.pi, FRAMES - 20)) ** 2
    return curve


def weights_of(**heights: float) -> np.ndarray:
    weights = np.zeros((FRAMES, len(WEIGHTS)))
    for name, height in heights.items():
        weights[:, WEIGHTS.index(name)] = swell(height)
    return weights


def markers_of(
    weights: np.ndarray, layout: str = "mediapipe-218", depth: float = 0.1, noise: float = 0.0
) -> MarkerTrack:
    """Where the markers go; ``depth`` is the share of forward motion that is seen."""
    known: Layout = load_layout(layout)
    moved = np.einsum("tk,kmc->tmc", weights, basis(layout)) * [1.0, 1.0, depth]
    moved = moved + np.random.default_rng(0).normal(0.0, noise, moved.shape)
    return MarkerTrack(known.markers, known.places + moved, RATE)


def channel(weights: np.ndarray, name: str) -> np.ndarray:
    return weights[:, WEIGHTS.index(name)]
