"""The head: how far and how fast it turns, and whether with the reference.

Conventions
-----------
Angles are yaw, pitch and roll in degrees (`mien.core.channels.HEAD`). Where a head looks at rest is the camera's
business: a constant offset of each angle is removed and given beside.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.metrics.face_track import FaceTrack
from mien.metrics.pairing import FEWEST, agreement, speech_frames

__all__ = ["evaluate", "validate"]

Array = NDArray[np.float64]
_STILL = 0.05  # degrees of standard deviation: a head that moves less was not recorded moving


def validate(reference: FaceTrack, estimate: FaceTrack) -> None:
    """Refuse two faces if the head's motion is not known of both.

    Raises
    ------
    InputError
    """
    for track in (reference, estimate):
        _angles(track)


def evaluate(
    reference: FaceTrack, estimate: FaceTrack, *, counted: NDArray[np.bool_] | None = None
) -> dict[str, float]:
    """Score the motion of a head against another's.

    Returns
    -------
    dict of str to float
        ``yaw_*``, ``pitch_*``, ``roll_*`` (`mien.metrics.pairing.agreement`, degrees); ``head_speed_reference_deg_s``,
        ``head_speed_estimate_deg_s``: root of the mean squared angular velocity; ``head_error_deg``: root of the mean
        squared difference of the three angles together, their constant offsets removed.

    Raises
    ------
    InputError
        As `validate`, or if too few frames show both.
    """
    validate(reference, estimate)
    frames = min(len(reference.landmarks), reference.rate.frames_covering(estimate.times[-1] + 1e-9) + 1)
    laid = estimate.resampled(reference.rate, frames)
    one, other, fps = _angles(reference)[:frames], _angles(laid), reference.rate.fps
    wanted = speech_frames(reference.phones, reference.times[:frames], fps) if counted is None else counted[:frames]
    held = wanted & np.isfinite(one).all(axis=1) & np.isfinite(other).all(axis=1)
    if held.sum() < FEWEST:
        raise InputError(f"{reference.name} and {estimate.name}: {int(held.sum())} frames show both heads")
    scores: dict[str, float] = {}
    for axis, name in enumerate(("yaw", "pitch", "roll")):
        scores |= agreement(name, one[:, axis], other[:, axis], held, fps, "deg")
    difference = (other - one)[held]
    scores["head_error_deg"] = float(np.sqrt(((difference - difference.mean(axis=0)) ** 2).sum(axis=1).mean()))
    moving = held[:-1] & held[1:]
    for kind, angles in (("reference", one), ("estimate", other)):
        steps = np.diff(angles, axis=0)[moving] * fps
        scores[f"head_speed_{kind}_deg_s"] = float(np.sqrt((steps**2).sum(axis=1).mean())) if len(steps) else 0.0
    return scores


def _angles(track: FaceTrack) -> Array:
    """The head's angles without jumps of a full turn between seen frames.

    Raises
    ------
    InputError
        If they are not known.
    """
    if track.head is None:
        raise InputError(f"{track.name} does not say how the head moves")
    angles = track.head
    seen = np.isfinite(angles).all(axis=1)
    result = angles.copy()
    if seen.any():
        result[seen] = np.unwrap(angles[seen], period=360.0, axis=0)
    return result
