"""A face of 26 markers that speaks and turns its head, made by rule, for tests on known answers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from mien.capture.cleaning.groups import MarkerGroups
from mien.capture.cleaning.normalise import apply
from mien.core.timeline import FrameRate
from mien.core.tracks import MarkerTrack

RIGID = {
    "forehead": (0, 70, 10),
    "temple_l": (55, 50, -25),
    "temple_r": (-55, 50, -25),
    "eye_l": (45, 30, -10),
    "eye_r": (-45, 30, -10),
    "bridge": (0, 28, 12),
    "nose": (0, 0, 30),
}
UPPER = {
    "brow_l1": (15, 45, 12),
    "brow_l2": (35, 48, 3),
    "brow_r1": (-15, 45, 12),
    "brow_r2": (-35, 48, 3),
    "cheek_l": (45, -5, -5),
    "cheek_r": (-45, -5, -5),
}
MOUTH = {
    "lip_u": (0, -28, 24),
    "lip_l": (0, -30, 23),
    "lip_ul": (10, -27, 21),
    "lip_ur": (-10, -27, 21),
    "lip_ll": (10, -31, 20),
    "lip_lr": (-10, -31, 20),
    "corner_l": (25, -30, 12),
    "corner_r": (-25, -30, 12),
    "outer_u": (0, -22, 25),
    "outer_l": (0, -38, 22),
    "chin": (0, -62, 18),
    "chin_l": (18, -58, 10),
    "chin_r": (-18, -58, 10),
}
NAMES = (*RIGID, *UPPER, *MOUTH)
REST = np.array([*RIGID.values(), *UPPER.values(), *MOUTH.values()], dtype=float)
GROUPS = MarkerGroups(tuple(RIGID), tuple(UPPER), tuple(MOUTH), "nose", "eye_l", "eye_r", "lip_u", "lip_l")


def column(name: str) -> int:
    return NAMES.index(name)


def speaking(frames: int = 120, fps: float = 25, noise: float = 0.0, seed: int = 0) -> MarkerTrack:
    """The face in its own head: the jaw, the lip corners and the brows move; it starts at rest for 0.4 s."""
    t = np.arange(frames) / fps
    started = np.clip((t - 0.4) / 0.1, 0, 1)
    jaw = started * 5 * (1 - np.cos(2 * np.pi * 2.1 * t)) / 2 * (1 + 0.5 * np.sin(2 * np.pi * 0.6 * t))
    width = started * 3 * np.sin(2 * np.pi * 1.3 * t + 1)
    brow = started * 3 * np.sin(2 * np.pi * 0.5 * t)
    positions = np.repeat(REST[None], frames, axis=0)
    for name, share in {
        "lip_l": 1,
        "lip_ll": 0.8,
        "lip_lr": 0.8,
        "outer_l": 1,
        "chin": 1.2,
        "chin_l": 1,
        "chin_r": 1,
    }.items():
        positions[:, column(name), 1] -= share * jaw
        positions[:, column(name), 2] -= 0.2 * share * jaw
    for name in MOUTH:
        positions[:, column(name), 0] += width * REST[column(name), 0] / 25
    for name in UPPER:
        positions[:, column(name), 1] += brow * (1.0 if "brow" in name else 0.2)
    positions += np.random.default_rng(seed).normal(0, noise, positions.shape) if noise else 0.0
    return MarkerTrack(NAMES, positions, FrameRate.of(fps))


def head_motion(frames: int = 120, fps: float = 25, scale: float = 0.0) -> NDArray[np.float64]:
    """Slow turns of up to 12 degrees and shifts of up to 30 mm; ``scale`` changes the size by that share."""
    t = np.arange(frames) / fps
    angles = np.stack([12 * np.sin(0.9 * t), 8 * np.sin(1.4 * t + 1), 5 * np.sin(1.1 * t + 2)], axis=1)
    head = np.zeros((frames, 4, 4))
    head[:, :3, :3] = Rotation.from_euler("yxz", angles, degrees=True).as_matrix()
    head[:, :3, :3] *= (1 + scale * np.sin(0.7 * t))[:, None, None]
    shift = np.stack([30 * np.sin(0.5 * t), 10 * np.cos(0.8 * t), 20 * np.sin(0.3 * t)], axis=1)
    head[:, :3, 3] = shift + np.array([5.0, 40.0, -200.0])
    head[:, 3, 3] = 1
    return head


def recorded(track: MarkerTrack, head: NDArray[np.float64]) -> MarkerTrack:
    return MarkerTrack(track.names, apply(head, track.positions), track.rate)


def with_positions(track: MarkerTrack, positions: NDArray[np.float64]) -> MarkerTrack:
    return MarkerTrack(track.names, positions, track.rate)
