"""Phone samples and the co-articulation areas between them (Deng et al. 2006, section IV).

The sample of a phone is the pose in the middle frame of the phone. The frames between the samples of neighbouring
phones are their co-articulation area.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from mien.motion.mouth.recorded_mouths import RecordedMouth

__all__ = ["Area", "SampledUtterance", "areas", "sample_phones"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SampledUtterance:
    """Phones of an utterance with the pose in the middle of each.

    Attributes
    ----------
    labels : tuple of str
        Phones whose middle was recorded, in order.
    places : tuple of int
        Place of each in the phone tier: neighbours in the tier differ by one.
    middles : ndarray of int, shape (phones,)
        Middle frame of each.
    times : ndarray, shape (frames,)
        Seconds.
    poses : ndarray, shape (frames, components)
    """

    labels: tuple[str, ...]
    places: tuple[int, ...]
    middles: NDArray[np.int64]
    times: Floats
    poses: Floats


@dataclass(frozen=True, eq=False)
class Area:
    """One recorded instance of a diphone or triphone.

    Attributes
    ----------
    phones : tuple of str
        Two or three.
    samples : ndarray, shape (phones, components)
    times : ndarray, shape (frames,)
        Normalised (Eq. 1 and 5): 0 at the first sample, 1 at the last, both included; they tie the curves down at the
        ends, where at 25 frames per second one instance has no more than a frame or two in between.
    poses : ndarray, shape (frames, components)
    """

    phones: tuple[str, ...]
    samples: Floats
    times: Floats
    poses: Floats


def sample_phones(mouth: RecordedMouth, poses: Floats, frame_time: float) -> SampledUtterance:
    """Find the sample of each phone.

    Parameters
    ----------
    mouth : RecordedMouth
    poses : ndarray, shape (frames, components)
        Of the frames of ``mouth``.
    frame_time : float
        Seconds per frame; a phone whose middle is further than this from any frame was not recorded.
    """
    found: list[tuple[str, int, int]] = []
    for place, phone in enumerate(mouth.phones):
        frame = int(np.abs(mouth.times - phone.middle).argmin())
        if abs(mouth.times[frame] - phone.middle) <= frame_time:
            found.append((phone.label, place, frame))
    return SampledUtterance(
        tuple(label for label, _, _ in found),
        tuple(place for _, place, _ in found),
        np.array([frame for _, _, frame in found], dtype=np.int64),
        mouth.times,
        poses,
    )


def areas(utterances: Sequence[SampledUtterance], phones: int) -> Iterator[Area]:
    """Every recorded area of ``phones`` neighbouring phones (2: diphones, 3: triphones) that has a frame inside."""
    for said in utterances:
        for first in range(len(said.labels) - phones + 1):
            last = first + phones - 1
            if any(after - before != 1 for before, after in pairwise(said.places[first : last + 1])):
                continue
            start, end = int(said.middles[first]), int(said.middles[last])
            if end - start < 2:  # no frame between the samples
                continue
            span = said.times[end] - said.times[start]
            yield Area(
                said.labels[first : last + 1],
                said.poses[said.middles[first : last + 1]],
                (said.times[start : end + 1] - said.times[start]) / span,
                said.poses[start : end + 1],
            )
