"""The mouth: how far lips and chin follow the reference, on the face that is shown.

Conventions
-----------
* The mouth is 48 landmarks: outer lips, inner lips and chin (`mien.metrics.sites`), or what of them both have.
* Lip opening is the distance of the middles of the inner lips (landmarks 13 and 14), width that of the corners (61 and
  291), both seen from the front: depth is left out, since a tracker hardly sees it.
* One constant offset per landmark is removed before distances are taken, since two faces differ at rest; it is given
  beside them. Several takes of a speaker share one: give it as ``offset``.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mien.capture.layouts import load_layout
from mien.metrics.face_track import LANDMARKS, FaceTrack
from mien.metrics.pairing import Pair, agreement, constant_offset, frontal, paired
from mien.metrics.sites import Sites, mouth_sites

__all__ = ["evaluate", "mouth_pair", "validate"]

Array = NDArray[np.float64]


def mouth_pair(
    reference: FaceTrack, estimate: FaceTrack, counted: NDArray[np.bool_] | None = None
) -> tuple[Pair, Sites]:
    """The mouths of both side by side, and where the lips are among their landmarks.

    Raises
    ------
    InputError
        If one lacks the middles of the lips or the corners, or they share too few frames.
    """
    layout = load_layout(LANDMARKS)
    mouth = [layout.markers[place] for place in mouth_sites(layout, layout.markers).mouth]
    pair = paired(reference, estimate, mouth, counted, least=4)
    return pair, mouth_sites(layout, pair.names)


def validate(reference: FaceTrack, estimate: FaceTrack) -> None:
    """Refuse two faces whose mouths cannot be compared.

    Raises
    ------
    InputError
        As `mouth_pair`.
    """
    mouth_pair(reference, estimate)


def evaluate(
    reference: FaceTrack,
    estimate: FaceTrack,
    *,
    counted: NDArray[np.bool_] | None = None,
    offset: Array | None = None,
) -> dict[str, float]:
    """Score a mouth against another.

    Parameters
    ----------
    reference, estimate : FaceTrack
        `FaceTrack.of_channels` shows channels on the default face, `FaceTrack.of_take` is a recording.
    counted : ndarray of bool, shape (frames of the reference,), or None
        Frames to score; None: from two before the first phone to two after the last, or all.
    offset : ndarray, shape (landmarks, 3), or None
        Constant offset of the estimate, mm, where several takes share one (`constant_offset` of `mouth_pair`); None
        takes that of these frames.

    Returns
    -------
    dict of str to float
        ``opening_*`` and ``width_*`` (`mien.metrics.pairing.agreement`); ``mouth_rms_mm``, ``mouth_rms_frontal_mm``,
        ``lips_rms_mm``, ``lips_rms_frontal_mm``: root of the mean squared distance over landmarks and frames, in space
        and seen from the front, the constant offset removed; ``mouth_rms_with_offset_mm``: without removing it;
        ``mouth_offset_x_mm``, ``_y_``, ``_z_``: its mean over the landmarks; ``lip_vertex_error_mm2``: greatest squared
        distance among the lips, mean over frames (Xing et al. 2023, CodeTalker), the offset removed; ``frames``.

    Raises
    ------
    InputError
        As `validate`.

    Examples
    --------
    >>> from mien.core.timeline import FrameRate
    >>> from mien.core.tracks import ChannelTrack
    >>> jaw = 0.3 + 0.2 * np.sin(np.arange(50) / 2)
    >>> one, other = (
    ...     FaceTrack.of_channels(ChannelTrack(("jawOpen",), curve[:, None], FrameRate.of(25)))
    ...     for curve in (jaw, jaw / 2)
    ... )
    >>> scores = evaluate(one, other)
    >>> round(scores["opening_r"], 2), round(scores["opening_spread"], 1)
    (1.0, 0.5)
    """
    pair, sites = mouth_pair(reference, estimate, counted)
    held = pair.counted
    scores: dict[str, float] = {"frames": float(held.sum())}
    for name, (one, other) in (("opening", sites.opening), ("width", sites.width)):
        curves = [frontal(positions, one, other) for positions in (pair.reference, pair.estimate)]
        scores |= agreement(name, curves[0], curves[1], held, pair.fps)
    removed = constant_offset(pair) if offset is None else offset
    raw = (pair.estimate - pair.reference)[held]
    left = raw - removed
    lips = left[:, sites.lips]
    scores |= {
        "mouth_rms_mm": _rms(left),
        "mouth_rms_frontal_mm": _rms(left[:, :, :2]),
        "lips_rms_mm": _rms(lips),
        "lips_rms_frontal_mm": _rms(lips[:, :, :2]),
        "mouth_rms_with_offset_mm": _rms(raw),
        **{f"mouth_offset_{axis}_mm": float(value) for axis, value in zip("xyz", removed.mean(axis=0), strict=True)},
        "lip_vertex_error_mm2": float((lips**2).sum(axis=2).max(axis=1).mean()) if lips.shape[1] else float("nan"),
    }
    return scores


def _rms(difference: Array) -> float:
    """Root of the mean squared length, mm."""
    return float(np.sqrt((difference**2).sum(axis=2).mean())) if difference.shape[1] else float("nan")
