"""How loud a take is, and what a person should hear about it before going on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.core.audio import Audio
from mien.core.errors import Note

__all__ = ["Levels", "level_notes", "measure_levels"]

QUIET_DB = -36.0
"""dBFS; speech (RMS) below it drowns in the noise of most microphones."""
LEAST_REST = 0.15
"""Seconds of rest to be left before and after the speech: the face starts and ends at rest."""
_FULL = 0.999
_FULL_RUN = 3  # samples in a row at full scale: a peak that was cut off; one alone may be chance
_SPEECH_BELOW_LOUDEST = 20.0  # dB; softer than that beside the loudest 20 ms is rest or the edge of a sound
_SPEECH_RUN = 3  # blocks in a row that loud: a click is shorter
_SILENT_DB = -60.0
_BLOCK = 0.02  # seconds
_FLOOR = 1e-10


@dataclass(frozen=True)
class Levels:
    """Loudness of a take.

    Attributes
    ----------
    peak : float
        dBFS of the highest sample.
    speech : float
        RMS in dBFS over the 20 ms blocks that are less than 20 dB below the loudest.
    before, after : float
        Seconds until the first and from the last run of three of those blocks.
    clipped : int
        Places where three samples or more in a row are at full scale.
    """

    peak: float
    speech: float
    before: float
    after: float
    clipped: int


def measure_levels(audio: Audio) -> Levels:
    """Measure a take.

    Examples
    --------
    >>> tone = 0.5 * np.sin(np.arange(8000) * 0.3)
    >>> levels = measure_levels(Audio(np.concatenate([np.zeros(4000), tone, np.zeros(2000)]), 8000))
    >>> round(levels.peak), round(levels.speech), round(levels.before, 2), round(levels.after, 2), levels.clipped
    (-6, -9, 0.5, 0.25, 0)
    """
    samples = audio.samples.astype(np.float64)
    length = max(1, round(_BLOCK * audio.rate))
    padded = np.pad(samples, (0, -len(samples) % length)) if len(samples) else np.zeros(length)
    power = (padded.reshape(-1, length) ** 2).mean(axis=1)
    loud = power >= power.max() * 10 ** (-_SPEECH_BELOW_LOUDEST / 10)
    starts, ends = _runs(loud, _SPEECH_RUN)
    if not len(starts):
        starts, ends = _runs(loud, 1)
    return Levels(
        peak=_decibel(float(np.abs(samples).max(initial=0.0)) ** 2),
        speech=_decibel(float(power[loud].mean())),
        before=float(starts[0]) * length / audio.rate,
        after=max(0.0, audio.duration - float(ends[-1]) * length / audio.rate),
        clipped=len(_runs(np.abs(samples) >= _FULL, _FULL_RUN)[0]),
    )


def _runs(true: NDArray[np.bool_], least: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Starts and ends of all runs of so many or more.

    >>> [place.tolist() for place in _runs(np.array([True, False, True, True]), 2)]
    [[2], [4]]
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], true, [False]]).astype(np.int8)))
    starts, ends = edges[::2], edges[1::2]
    long_enough = ends - starts >= least
    return starts[long_enough], ends[long_enough]


def _decibel(power: float) -> float:
    return float(10 * np.log10(max(power, _FLOOR)))


def level_notes(levels: Levels) -> tuple[Note, ...]:
    """What is wrong with the level, worst first; empty where nothing is.

    Examples
    --------
    >>> [note.message for note in level_notes(Levels(-1.0, -50.0, 0.5, 0.0, 0))]  # doctest: +NORMALIZE_WHITESPACE
    ['too quiet: speech at -50 dBFS (better above -36): go nearer to the microphone, or turn it up',
     'the speech goes on to the end of the recording: wait a moment before you stop']
    """
    if levels.peak < _SILENT_DB:
        return (
            Note("warning", f"silent: nothing above {_SILENT_DB:g} dBFS: is the microphone on, and the right one?"),
        )
    said = []
    if levels.clipped:
        said.append(f"too loud: cut off at full scale in {levels.clipped} places: turn the microphone down")
    if levels.speech < QUIET_DB:
        said.append(
            f"too quiet: speech at {levels.speech:.0f} dBFS (better above {QUIET_DB:g}): go nearer to the microphone, "
            "or turn it up"
        )
    if levels.before < LEAST_REST:
        said.append("the speech begins with the recording: wait a moment before you speak")
    if levels.after < LEAST_REST:
        said.append("the speech goes on to the end of the recording: wait a moment before you stop")
    return tuple(Note("warning", message) for message in said)
