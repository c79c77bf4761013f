"""Jitter: a tracker's noise taken out of marker motion without blunting the closures of the lips.

A plain low-pass opens the lips at every /b/: at 25 frames a second a closure lasts one to three frames and is as fast
as the noise (docs/tables/cleaning.md shows how much). Two facts help.

* Most of a tracker's noise moves a group of markers as one block. So the motion of a group is split into the
  block's translation and the shape around it. The translation is low-passed (Butterworth, forwards and backwards: no
  delay); that leaves all distances within the group, such as the opening of the lips, exactly as they were.
* Noise is seen where the face rests. So the shape is smoothed (Gaussian in time) only while the group is nearly still,
  and left alone while it moves: the weight runs from 1 below `JitterSettings.still` to 0 above
  `JitterSettings.moving`, by the largest speed within `JitterSettings.around` seconds.

The head's motion, slow by nature, is low-passed as rotation and translation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d, maximum_filter1d
from scipy.signal import butter, sosfiltfilt
from scipy.spatial.transform import Rotation

from mien.capture.cleaning.normalise import columns
from mien.capture.cleaning.repairs import complete, runs
from mien.core.errors import InputError
from mien.core.timeline import FrameRate
from mien.core.tracks import MarkerTrack

__all__ = ["JitterSettings", "jitter", "low_passed", "smooth_group", "smooth_head"]


@dataclass(frozen=True)
class JitterSettings:
    """How one group of markers is smoothed. The defaults were chosen on docs/tables/cleaning.md.

    Attributes
    ----------
    translation_hz : float
        Cut-off (-6 dB) of the group's translation; 0 leaves the translation alone, and so does a cut-off at or above
        half the frame rate, where there is nothing to cut.
    window : float
        Standard deviation of the Gaussian that smooths the shape at rest, s; 0 leaves the shape alone.
    still, moving : float
        Speeds of the group in mm/s: below the first its shape is smoothed in full, above the second not at all. The
        speed of a group is that of its faster markers (90th percentile), so that a blink counts.
    around : float
        Seconds before and after over which the largest speed counts.

    Raises
    ------
    InputError
        If a number is negative, or ``still`` is not below ``moving``.
    """

    translation_hz: float = 6.0
    window: float = 0.05
    still: float = 15.0
    moving: float = 30.0
    around: float = 0.08

    def __post_init__(self) -> None:
        if min(self.translation_hz, self.window, self.still, self.around) < 0 or not self.still < self.moving:
            raise InputError(f"jitter settings: numbers are 0 or more, and still is below moving; got {self}")


def smooth_group(track: MarkerTrack, names: Sequence[str], settings: JitterSettings | None = None) -> MarkerTrack:
    """Take the jitter out of one group of markers; the other markers stay as they are.

    Parameters
    ----------
    track : MarkerTrack
        Normalised, mm. Frames in which a marker of the group is NaN part the track into stretches that are smoothed
        on their own; such frames are left as they are.
    names : sequence of str
        The markers of the group.
    settings : JitterSettings, optional

    Raises
    ------
    InputError
        If a marker is unknown.
    """
    settings = settings or JitterSettings()
    group = columns(track, names)
    positions = track.positions.copy()
    if not group:
        return track
    for first, last in runs(complete(positions[:, group], 2)):
        stretch = positions[first : last + 1][:, group]
        middle = stretch.mean(axis=1, keepdims=True)
        shape = _shape_at_rest(stretch - middle, track.rate, settings)
        positions[first : last + 1, group] = low_passed(middle, track.rate, settings.translation_hz) + shape
    return MarkerTrack(track.names, positions, track.rate)


def smooth_head(head: NDArray[np.float64], rate: FrameRate, hz: float) -> NDArray[np.float64]:
    """Low-pass the motion of the head, shape (frames, 4, 4): rotation, translation and scale; NaN frames stay NaN."""
    result = head.copy()
    for first, last in runs(complete(head, 2)):
        part = head[first : last + 1]
        scale = np.cbrt(np.linalg.det(part[:, :3, :3]))
        turns = Rotation.from_matrix(part[:, :3, :3] / scale[:, None, None])
        middle = turns.mean()
        vectors = (middle.inv() * turns).as_rotvec()
        smooth = (middle * Rotation.from_rotvec(low_passed(vectors, rate, hz))).as_matrix()
        result[first : last + 1, :3, :3] = smooth * low_passed(scale, rate, hz)[:, None, None]
        result[first : last + 1, :3, 3] = low_passed(part[:, :3, 3], rate, hz)
    return result


def low_passed(values: NDArray[np.float64], rate: FrameRate, hz: float) -> NDArray[np.float64]:
    """Second-order Butterworth, forwards and backwards along axis 0; -6 dB at ``hz``. Short or fast: unchanged.

    Examples
    --------
    >>> bool(np.allclose(low_passed(np.arange(50.0), FrameRate.of(25), 6.0), np.arange(50.0), atol=0.01))
    True
    """
    if hz <= 0 or hz >= 0.5 * rate.fps or len(values) < 4:
        return values
    sections = butter(2, hz / (0.5 * rate.fps), output="sos")
    padding = min(len(values) - 1, max(9, round(2 * rate.fps / hz)))
    smooth: NDArray[np.float64] = sosfiltfilt(sections, values, axis=0, padtype="odd", padlen=padding)
    return smooth


def jitter(positions: NDArray[np.float64]) -> float:
    """Jitter of markers at rest, mm: root of the mean squared second difference, over what is not NaN.

    White noise of standard deviation s per coordinate gives ``s * sqrt(18)``.
    """
    bends = (np.diff(positions, 2, axis=0) ** 2).sum(axis=-1)
    return float(np.sqrt(np.nanmean(bends))) if np.isfinite(bends).any() else float("nan")


def _shape_at_rest(shape: NDArray[np.float64], rate: FrameRate, settings: JitterSettings) -> NDArray[np.float64]:
    """Shape (frames, markers, 3) smoothed where it is nearly still."""
    if settings.window == 0 or len(shape) < 2:
        return shape
    smooth = gaussian_filter1d(shape, settings.window * rate.fps, axis=0, mode="nearest")
    # Speed over about 0.05 s whatever the rate, so that noise counts alike at 25 and at 120 frames a second.
    calm = gaussian_filter1d(shape, 0.024 * rate.fps, axis=0, mode="nearest")
    speeds = np.linalg.norm(np.gradient(calm, axis=0) * rate.fps, axis=2)
    reach = 2 * round(settings.around * rate.fps) + 1
    speed = maximum_filter1d(np.quantile(speeds, 0.9, axis=1), reach, mode="nearest")
    moving = np.clip((speed - settings.still) / (settings.moving - settings.still), 0.0, 1.0)[:, None, None]
    mixed: NDArray[np.float64] = moving * shape + (1.0 - moving) * smooth
    return mixed
