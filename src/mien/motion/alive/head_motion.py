"""Head motion learned from recorded heads: ridge regression of yaw, pitch and roll on the voice's prosody.

Features are pitch, level, their slopes, voicing and pauses within 0.6 s about a moment (as in Busso et al. 2007, IEEE
TASLP 15(3); the regression is ours, the paper has hidden Markov models). Learned from GRID's speaker 1 (Cooke et al.
2006, CC BY 4.0), whose head moves little in three-second commands: `benchmarks/head_motion.py` measures on takes held
out how much of the recorded motion it explains, beside the hand-made rule. `tools/learn_head.py` learns what ships.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from mien.core import channels
from mien.core.assets import asset
from mien.core.audio import Audio
from mien.core.errors import InputError
from mien.core.files import replace_when_complete
from mien.core.timeline import FrameRate, Tier
from mien.core.utterance import PAUSE, Utterance
from mien.corpus.take import Take
from mien.speech.pitch import level_contour, pitch_contour

__all__ = ["LearnedHead", "default_head", "head_angles"]

Floats = NDArray[np.float64]
RATE = 25.0
"""Frames per second at which it was learned and is predicted."""
REACH, STEP = 15, 3  # frames of context to each side, and between two of them
GAIN = 2.0
"""How much of the prediction is performed. Regression shrinks: this brings the spread back to the recorded one."""
_BLOCK = 4096  # moments
_QUIET = -70.0  # dBFS: nothing below is told apart


class _Spoken(Protocol):
    @property
    def audio(self) -> Audio: ...

    @property
    def phones(self) -> Tier: ...


class LearnedHead:
    """Head angles from prosody.

    Parameters
    ----------
    ridge : float
        Strength of the penalty on the scaled weights.

    Attributes
    ----------
    weights_ : ndarray, shape (features, 3)
        Degrees of yaw, pitch and roll.
    mean_, size_ : ndarray, shape (features,)
    """

    def __init__(self, ridge: float = 100.0) -> None:
        self.ridge = ridge

    def fit(self, takes: Sequence[Take]) -> LearnedHead:
        """Learn from takes with head poses; frames from the first word to the last, about their mean in each take."""
        pairs = [pair for take in takes if (pair := self.speaking(take)) is not None]
        if not pairs:
            raise InputError("head motion: no take has the poses of a head throughout")
        return self.fit_frames(np.concatenate([rows for rows, _ in pairs]), np.concatenate([goal for _, goal in pairs]))

    def fit_frames(self, rows: Floats, angles: Floats) -> LearnedHead:
        """Learn from features (frames, features) and angles (frames, 3)."""
        self.mean_, self.size_ = rows.mean(axis=0), rows.std(axis=0) + 1e-9
        scaled = (rows - self.mean_) / self.size_
        gram = scaled.T @ scaled + self.ridge * np.eye(scaled.shape[1])
        self.weights_ = np.linalg.solve(gram, scaled.T @ angles)
        return self

    def speaking(self, take: Take) -> tuple[Floats, Floats] | None:
        """Features and angles of a take's speech; None where it has no head, or too little of it."""
        if take.head is None or not np.isfinite(take.head).all() or not len(take.words):
            return None
        times = take.markers.rate.times(len(take.head))
        inside = (times >= take.words.intervals[0].start - 0.1) & (times <= take.words.intervals[-1].end + 0.1)
        if inside.sum() < 10 or abs(take.markers.rate.fps - RATE) > 0.01:
            return None
        angles = head_angles(take.head)[inside]
        return prosodic_features(take, times)[inside], angles - angles.mean(axis=0)

    def predict(self, features: Floats) -> Floats:
        """Yaw, pitch, roll, shape (frames, 3), degrees."""
        return np.asarray((features - self.mean_) / self.size_ @ self.weights_)

    def perform(self, utterance: Utterance, rate: FrameRate) -> Floats:
        """Head channels for every frame that covers the sound, (frames, channels); still where nothing is said."""
        angles = self.angles(utterance, rate)
        values = np.zeros((len(angles), len(channels.ALL)))
        values[:, [channels.ALL.index(name) for name in channels.HEAD]] = angles
        return values

    def angles(self, utterance: Utterance, rate: FrameRate) -> Floats:
        """The same as yaw, pitch and roll alone, (frames, 3)."""
        times = rate.times(rate.frames_covering(utterance.duration))
        spoken = [phone for phone in utterance.phones if phone.label != PAUSE]
        if not spoken or not len(times):
            return np.zeros((len(times), 3))
        own = np.arange(0.0, utterance.duration + 2 / RATE, 1 / RATE)
        plain = _plain_features(utterance, own)
        angles = np.empty((len(own), 3))
        for first in range(0, len(own), _BLOCK):  # what is seen about each moment of an hour is not held at once
            here = slice(first, first + _BLOCK)
            angles[here] = GAIN * self.predict(_about(plain, range(len(own))[here]))
        inside = (own >= spoken[0].start - 0.1) & (own <= spoken[-1].end + 0.1)
        angles = angles - angles[inside].mean(axis=0)
        ramp = np.clip(np.minimum(own - spoken[0].start + 0.6, spoken[-1].end + 0.6 - own) / 0.6, 0, 1)
        angles = angles * (ramp * ramp * (3 - 2 * ramp))[:, None]
        return np.stack([np.interp(times, own, column) for column in angles.T], axis=1)

    def write(self, path: str | Path) -> None:
        """Keep it in a ``.npz`` file."""
        content = io.BytesIO()
        np.savez(content, weights=self.weights_.astype(np.float32), mean=self.mean_.astype(np.float32),
                 size=self.size_.astype(np.float32), ridge=np.float32(self.ridge))  # fmt: skip
        with replace_when_complete(path) as unfinished:
            unfinished.write_bytes(content.getvalue())


@cache
def default_head() -> LearnedHead:
    """The one that comes with mien, from `tools/learn_head.py`."""
    content = asset("performance/head.npz").read_bytes()
    with np.load(io.BytesIO(content), allow_pickle=False) as kept:
        head = LearnedHead(float(kept["ridge"]))
        head.weights_, head.mean_, head.size_ = (kept[name].astype(np.float64) for name in ("weights", "mean", "size"))
    return head


def head_angles(head: Floats) -> Floats:
    """Yaw, pitch, roll of rigid motions (frames, 4, 4) against the middle frame, degrees, shape (frames, 3).

    Examples
    --------
    >>> from mien.face.posing import head_rotation
    >>> turns = np.tile(np.eye(4), (3, 1, 1))
    >>> turns[2, :3, :3] = head_rotation(10, 5, -3)
    >>> head_angles(turns).round(6)[2].tolist()
    [10.0, 5.0, -3.0]
    """
    turns = head[:, :3, :3] / np.cbrt(np.linalg.det(head[:, :3, :3]))[:, None, None]
    relative = np.einsum("ji,tjk->tik", turns[len(turns) // 2], turns)
    yaw = np.degrees(np.arctan2(relative[:, 0, 2], relative[:, 2, 2]))
    pitch = np.degrees(np.arcsin(np.clip(relative[:, 1, 2], -1, 1)))
    roll = -np.degrees(np.arctan2(relative[:, 1, 0], relative[:, 1, 1]))
    return np.stack([yaw, pitch, roll], axis=1)


def _pausing(phones: Tier, times: Floats) -> Floats:
    """1 in pauses, 0 in speech and beyond the phones, shape (times,)."""
    starts = np.array([phone.start for phone in phones])
    ends = np.array([phone.end for phone in phones])
    pause = np.array([phone.label == PAUSE for phone in phones], dtype=bool)
    at = np.searchsorted(starts, times, side="right") - 1
    held = np.maximum(at, 0)
    return np.where((at >= 0) & (times < ends[held]) & pause[held], 1.0, 0.0) if len(starts) else np.zeros(len(times))


def prosodic_features(spoken: _Spoken, times: Floats) -> Floats:
    """Pitch, level, slopes, voicing and pauses about moments 1 / `RATE` apart, shape (times, features)."""
    return _about(_plain_features(spoken, times), range(len(times)))


def _about(plain: Floats, moments: range) -> Floats:
    """What is seen about some moments in a row, `REACH` to each side; the ends of all last."""
    places = np.arange(moments.start - REACH, moments.stop + REACH).clip(0, len(plain) - 1)
    padded = plain[places]
    return np.hstack([padded[k : k + len(moments)] for k in range(0, 2 * REACH + 1, STEP)])


def _plain_features(spoken: _Spoken, times: Floats) -> Floats:
    """The same at the moments alone."""
    pitch, level = pitch_contour(spoken.audio), level_contour(spoken.audio)
    semitones = pitch.semitones(100.0)
    voiced = np.isfinite(semitones)
    height = np.zeros(len(times))
    if voiced.sum() > 1:
        height = np.interp(times, pitch.times[voiced], semitones[voiced]) - np.median(semitones[voiced])
    loud = np.clip(level.decibels_at(times), _QUIET, 0)
    sounding = np.interp(times, pitch.times, voiced.astype(np.float64))
    silent = _pausing(spoken.phones, times)
    return np.stack([height, loud, np.gradient(height), np.gradient(loud), sounding, silent], axis=1)
