"""Normalisation: the head's own motion taken out of marker tracks.

`three_point` is the normalisation of Deng et al. 2006, section IV: every frame is moved so that its nose
marker stands where the reference frame's does, and turned so that the local frame spanned by three nearly rigid points
(nose, two eye corners) falls on that of the reference.

`least_squares` fits all rigid markers at once (Kabsch 1976; with a scale: Umeyama 1991), so that the noise of one
marker moves the face less, and frames with some rigid markers missing can still be placed.

Both return the head's motion too: ``head @ normalised = recorded`` for every frame, in homogeneous columns.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.capture.cleaning.repairs import complete
from mien.core.errors import InputError, unknown_name
from mien.core.tracks import MarkerTrack

__all__ = [
    "Normalised",
    "apply",
    "best_similarity",
    "columns",
    "least_squares",
    "neutral_frame",
    "three_point",
]

# The second singular value of the rigid markers must be at least this share of the first: else they stand in a line.
_LINE = 0.02
_ROBUST_ROUNDS = 5


@dataclass(frozen=True, eq=False)
class Normalised:
    """A track without the motion of the head, and that motion.

    Attributes
    ----------
    track : MarkerTrack
        Positions in the head of the reference frame, mm; NaN in frames that could not be placed.
    head : ndarray, shape (frames, 4, 4)
        ``head @ normalised = recorded``; NaN in frames that could not be placed. Rigid, or a similarity if a scale
        was asked for.
    reference : ndarray, shape (markers, 3)
        The frame all others were laid on.
    """

    track: MarkerTrack
    head: NDArray[np.float64]
    reference: NDArray[np.float64]

    @property
    def unplaced(self) -> tuple[int, ...]:
        """Frames whose rigid markers were not enough to place them."""
        return tuple(int(i) for i in np.flatnonzero(~complete(self.head, 2)))


def columns(track: MarkerTrack, names: Sequence[str]) -> list[int]:
    """Columns of the named markers; InputError for a name that the track lacks."""
    for name in names:
        if name not in track.names:
            raise unknown_name("marker", name, track.names)
    return [track.names.index(name) for name in names]


def apply(transforms: NDArray[np.float64], positions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Move positions (frames, markers, 3) by one 4x4 transform per frame (frames, 4, 4).

    Examples
    --------
    >>> shift = np.eye(4)[None]; shift = shift + np.eye(4, k=3)[None] * 2.0
    >>> apply(shift, np.zeros((1, 1, 3))).tolist()
    [[[2.0, 0.0, 0.0]]]
    """
    moved: NDArray[np.float64] = np.einsum("fij,fmj->fmi", transforms[:, :3, :3], positions)
    return moved + transforms[:, None, :3, 3]


def three_point(
    track: MarkerTrack, nose: str, left_eye: str, right_eye: str, reference: NDArray[np.float64]
) -> Normalised:
    """Normalise as Deng et al. 2006 do: translate to the nose, rotate the local frame of three points.

    Parameters
    ----------
    track : MarkerTrack
    nose, left_eye, right_eye : str
        The three nearly rigid markers: the nose and the corners of the eyes.
    reference : ndarray, shape (markers, 3)
        A neutral frame with the mouth closed, of the same markers (see `neutral_frame`).

    Raises
    ------
    InputError
        If a marker is unknown, or the three points of the reference are missing or stand in a line.
    """
    points = columns(track, (nose, left_eye, right_eye))
    target = _local_frames(_checked_reference(track, reference)[None, points])[0]
    if np.isnan(target).any():
        raise InputError(f"reference frame: {nose!r}, {left_eye!r} and {right_eye!r} are missing or stand in a line")
    own = _local_frames(track.positions[:, points])
    # own and target map the local frame to space: recorded = own @ local, normalised = target @ local.
    return _normalised(track, own @ np.linalg.inv(target), reference)


def least_squares(
    track: MarkerTrack,
    rigid: Sequence[str],
    reference: NDArray[np.float64],
    scale: bool = False,
    robust: bool = False,
) -> Normalised:
    """Normalise by the rigid motion that best lays the rigid markers of each frame on the reference.

    Parameters
    ----------
    track : MarkerTrack
    rigid : sequence of str
        At least three markers that the face does not move: forehead, nose bridge, corners of the eyes.
    reference : ndarray, shape (markers, 3)
        The frame to lay all others on; the rigid markers missing in it are not used.
    scale : bool
        Fit one scale per frame too (a similarity): for trackers that see pixels and not distances.
    robust : bool
        Weigh down rigid markers that do not fit (iteratively, Cauchy weights): for motion with spikes in it.

    Raises
    ------
    InputError
        If a marker is unknown, or fewer than three usable ones are in the reference.

    Examples
    --------
    >>> from mien.core.timeline import FrameRate
    >>> rest = np.array([[0.0, 0.0, 0.0], [90.0, 0.0, 0.0], [45.0, -40.0, 30.0]])
    >>> moved = MarkerTrack(("a", "b", "c"), [rest, rest + [5.0, 0.0, 0.0]], FrameRate.of(25))
    >>> result = least_squares(moved, ("a", "b", "c"), rest)
    >>> bool(np.allclose(result.track.positions[1], rest)), np.allclose(result.head[1, :3, 3], [5.0, 0.0, 0.0])
    (True, True)
    """
    points = columns(track, rigid)
    target = _checked_reference(track, reference)[points]
    usable = complete(target)
    if _is_line(target[usable]):
        raise InputError(f"reference frame: needs three rigid markers not in a line, has {int(usable.sum())}")
    head = np.full((len(track), 4, 4), np.nan)
    for frame, recorded in enumerate(track.positions[:, points]):
        seen = usable & complete(recorded)
        if _is_line(recorded[seen]):
            continue
        head[frame] = np.linalg.inv(_laid(recorded[seen], target[seen], scale, robust))
    return _normalised(track, head, reference)


def _laid(recorded: NDArray[np.float64], target: NDArray[np.float64], scale: bool, robust: bool) -> NDArray[np.float64]:
    """The transform that lays recorded points on the target; with a scale the misfit must be the target's."""
    weights = np.ones(len(recorded))
    laid = best_similarity(recorded, target, weights, scale)
    for _ in range(_ROBUST_ROUNDS if robust else 0):
        misfit = np.linalg.norm(apply(laid[None], recorded[None])[0] - target, axis=1)
        weights = 1.0 / (1.0 + (misfit / max(float(np.median(misfit)) * 2.0, 1e-9)) ** 2)
        laid = best_similarity(recorded, target, weights, scale)
    return laid


def best_similarity(
    source: NDArray[np.float64], target: NDArray[np.float64], weights: NDArray[np.float64], scale: bool
) -> NDArray[np.float64]:
    """The 4x4 transform that best maps ``source`` onto ``target``, both (points, 3): Kabsch, or Umeyama with a scale.

    The rotation is always proper (no mirror).
    """
    share = (weights / weights.sum())[:, None]
    source_middle, target_middle = (share * source).sum(axis=0), (share * target).sum(axis=0)
    left, right = source - source_middle, target - target_middle
    u, sizes, vt = np.linalg.svd((share * right).T @ left)
    flip = np.array([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    factor = float((sizes * flip).sum() / (share * left**2).sum()) if scale else 1.0
    transform = np.eye(4)
    transform[:3, :3] = factor * (u * flip) @ vt
    transform[:3, 3] = target_middle - transform[:3, :3] @ source_middle
    return transform


def neutral_frame(
    track: MarkerTrack,
    upper_lip: str,
    lower_lip: str,
    rigid: Sequence[str],
    candidates: NDArray[np.bool_] | None = None,
) -> int:
    """Number of the frame that best shows a neutral face with the mouth closed.

    Among the frames that miss the fewest markers and (``candidates``) may be chosen, those whose lips are closest are
    kept (the tenth with the smallest opening, at least one); of these, the one that is nearest to their median face
    and moves least is chosen: a mouth at rest, not one pressed shut on its way through a /p/.

    Parameters
    ----------
    track : MarkerTrack
        As recorded; the head may move.
    upper_lip, lower_lip : str
        Markers whose distance is the opening of the lips.
    rigid : sequence of str
        Markers that take out the motion of the head.
    candidates : ndarray of bool, shape (frames,), optional
        Frames that may be chosen, such as those of the pauses.

    Raises
    ------
    InputError
        If no candidate frame shows both lips and three rigid markers.
    """
    lips = columns(track, (upper_lip, lower_lip))
    points = columns(track, rigid)
    seen = complete(track.positions)
    allowed = seen[:, lips].all(axis=1) & (seen[:, points].sum(axis=1) >= 3)
    if candidates is not None:
        allowed &= candidates
    if not allowed.any():
        raise InputError("no frame shows both lips and three rigid markers: no neutral frame can be chosen")
    visible = seen.sum(axis=1)
    allowed &= visible >= visible[allowed].max()
    first = track.positions[np.flatnonzero(allowed)[0]]
    still = least_squares(track, rigid, first).track.positions
    allowed &= complete(still[:, lips], 2)
    opening = np.linalg.norm(still[:, lips[0]] - still[:, lips[1]], axis=1)
    closed = np.flatnonzero(allowed & (opening <= np.quantile(opening[allowed], 0.1)))
    speed = np.linalg.norm(_differences(still), axis=2)
    unlike = np.linalg.norm(still[closed] - np.nanmedian(still[closed], axis=0), axis=2)
    cost = np.nanmean(unlike, axis=1) + np.nanmean(speed[closed], axis=1)
    return int(closed[np.argmin(cost)])


def _differences(positions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Largest of the steps to the frame before and after, per coordinate; 0 where there is no such step."""
    steps = np.nan_to_num(np.abs(np.diff(positions, axis=0)))
    none = np.zeros_like(positions[:1])
    result: NDArray[np.float64] = np.maximum(np.concatenate([none, steps]), np.concatenate([steps, none]))
    return result


def _local_frames(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Frames (n, 4, 4) of nose, left and right eye corner (n, 3, 3): origin nose, x along the eyes, z out of them."""
    nose, left, right = points[:, 0], points[:, 1], points[:, 2]
    with np.errstate(invalid="ignore", divide="ignore"):
        x = left - right
        x = x / np.linalg.norm(x, axis=1, keepdims=True)
        up = (left + right) / 2 - nose
        z = np.cross(x, up)
        line = np.linalg.norm(z, axis=1) < _LINE * np.linalg.norm(left - right, axis=1)
        z = z / np.linalg.norm(z, axis=1, keepdims=True)
    frames = np.zeros((len(points), 4, 4))
    frames[:, :3, :3] = np.stack([x, np.cross(z, x), z], axis=2)
    frames[:, :3, 3] = nose
    frames[:, 3, 3] = 1.0
    frames[line] = np.nan
    frames[np.isnan(frames).any(axis=(1, 2))] = np.nan
    return frames


def _is_line(points: NDArray[np.float64]) -> bool:
    if len(points) < 3:
        return True
    sizes = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(sizes[1] <= _LINE * sizes[0])


def _checked_reference(track: MarkerTrack, reference: NDArray[np.float64]) -> NDArray[np.float64]:
    if reference.shape != (len(track.names), 3):
        raise InputError(f"reference frame: expected shape ({len(track.names)}, 3), got {reference.shape}")
    return reference


def _normalised(track: MarkerTrack, head: NDArray[np.float64], reference: NDArray[np.float64]) -> Normalised:
    inverse = np.full_like(head, np.nan)
    placed = complete(head, 2)
    inverse[placed] = np.linalg.inv(head[placed])
    return Normalised(MarkerTrack(track.names, apply(inverse, track.positions), track.rate), head, reference.copy())
