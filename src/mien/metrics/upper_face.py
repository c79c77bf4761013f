"""The upper face: brows and lids, and how lively the whole of it is.

Conventions
-----------
* Inner and outer brow are the heights of their ends (landmarks 55 and 285; 70 and 300), mean of both sides; the lid gap
  is the distance of the lids' middles (159 and 145; 386 and 374) seen from the front, mean of both sides.
* The upper face is the landmarks of the layout's upper group but those that serve to take the head's motion out.
* One constant offset per landmark is removed, since two faces differ at rest; it is given beside.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mien.capture.layouts import load_layout
from mien.core.errors import InputError
from mien.metrics.face_track import LANDMARKS, FaceTrack
from mien.metrics.pairing import Pair, agreement, constant_offset, frontal, paired
from mien.metrics.published import upper_face_dynamics_deviation

__all__ = ["evaluate", "upper_face_pair", "validate"]

Array = NDArray[np.float64]

_BROWS = {"inner_brow": (55, 285), "outer_brow": (70, 300)}
_LIDS = ((159, 145), (386, 374))
_FEWEST = 4


def upper_face_pair(reference: FaceTrack, estimate: FaceTrack, counted: NDArray[np.bool_] | None = None) -> Pair:
    """The upper faces of both side by side.

    Raises
    ------
    InputError
        If they share fewer than four landmarks of it, or too few frames.
    """
    layout = load_layout(LANDMARKS)
    upper = [name for name in layout.groups["upper"] if name not in layout.rigid]
    return paired(reference, estimate, upper, counted, least=_FEWEST)


def validate(reference: FaceTrack, estimate: FaceTrack) -> None:
    """Refuse two faces whose upper parts cannot be compared (`upper_face_pair`)."""
    upper_face_pair(reference, estimate)


def evaluate(
    reference: FaceTrack,
    estimate: FaceTrack,
    *,
    counted: NDArray[np.bool_] | None = None,
    offset: Array | None = None,
) -> dict[str, float]:
    """Score an upper face against another.

    Parameters
    ----------
    reference, estimate, counted, offset
        As in `mien.metrics.mouth.evaluate`.

    Returns
    -------
    dict of str to float
        ``inner_brow_*``, ``outer_brow_*``, ``lid_gap_*`` (`mien.metrics.pairing.agreement`; those that both have);
        ``upper_face_rms_mm``, ``upper_face_rms_frontal_mm``: root of the mean squared distance, the constant offset
        removed; ``upper_face_offset_mm``: root of its mean square; ``upper_face_dynamics_signed_mm`` and
        ``_absolute_mm``: standard deviation over time of each landmark's distance from its mean, reference less
        estimate (above 0: the estimate moves too little), mean over landmarks (Xing et al. 2023, CodeTalker's FDD).

    Raises
    ------
    InputError
        As `validate`.
    """
    pair = upper_face_pair(reference, estimate, counted)
    held = pair.counted
    scores: dict[str, float] = {}
    for name, curves in _curves(pair).items():
        scores |= agreement(name, curves[0], curves[1], held, pair.fps)
    removed = constant_offset(pair) if offset is None else offset
    left = (pair.estimate - pair.reference)[held] - removed
    rest = pair.reference[held].mean(axis=0)
    laid = pair.estimate[held] - pair.estimate[held].mean(axis=0) + rest
    signed, absolute = upper_face_dynamics_deviation(pair.reference[held], laid, rest)
    return scores | {
        "upper_face_rms_mm": _rms(left),
        "upper_face_rms_frontal_mm": _rms(left[..., :2]),
        "upper_face_offset_mm": _rms(removed[None]),
        "upper_face_dynamics_signed_mm": signed,
        "upper_face_dynamics_absolute_mm": absolute,
    }


def _curves(pair: Pair) -> dict[str, tuple[Array, Array]]:
    """The named curves that both faces have, reference and estimate."""
    landmarks = load_layout(LANDMARKS).landmarks
    at = {name: place for place, name in enumerate(pair.names)}
    found: dict[str, tuple[Array, Array]] = {}
    for name, numbers in _BROWS.items():
        sides = [at[landmarks[n]] for n in numbers if landmarks[n] in at]
        if sides:
            found[name] = (pair.reference[:, sides, 1].mean(axis=1), pair.estimate[:, sides, 1].mean(axis=1))
    lids = [[at.get(landmarks[n], -1) for n in pairs] for pairs in _LIDS]
    whole = [(up, low) for up, low in lids if min(up, low) >= 0]
    if whole:
        found["lid_gap"] = (
            np.mean([frontal(pair.reference, *both) for both in whole], axis=0),
            np.mean([frontal(pair.estimate, *both) for both in whole], axis=0),
        )
    if not found:
        raise InputError("neither brows nor lids are among the landmarks that both have")
    return found


def _rms(difference: Array) -> float:
    """Root of the mean squared length, mm."""
    return float(np.sqrt((difference**2).sum(axis=-1).mean()))
