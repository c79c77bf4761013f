"""A face tracker's pixels to millimetres in mien's axes.

A tracker such as MediaPipe's face mesh assumes weak perspective: x and y are pixels of the picture (x right, y down),
and z has the scale of x, negative towards the camera. Nothing in one picture says how large a face is, so a length on
the face must be known or assumed; the assumption made is part of the result.

Facing a camera that does not mirror, the speaker's left is on the right of the picture: x keeps its sign, y and z turn.
A mirrored recording (many webcam programs) must be said to be one, or left and right change places.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.capture.cleaning.normalise import columns
from mien.core.errors import InputError
from mien.core.tracks import MarkerTrack

__all__ = ["OUTER_EYES_MM", "Metric", "scaled", "to_millimetres"]

# Between the outer corners of an adult's eyes; means in the literature run from about 85 to 97 mm.
OUTER_EYES_MM = 90.0


@dataclass(frozen=True, eq=False)
class Metric:
    """A track in millimetres, and what was assumed to get there.

    Attributes
    ----------
    track : MarkerTrack
        Millimetres; x to the speaker's left, y up, z forward.
    mm_per_pixel : float
    assumption : str
        One line for the manifest.
    """

    track: MarkerTrack
    mm_per_pixel: float
    assumption: str


def to_millimetres(
    pixels: MarkerTrack,
    between: tuple[str, str],
    millimetres: float = OUTER_EYES_MM,
    frame: int | None = None,
    mirrored: bool = False,
) -> Metric:
    """Bring weak-perspective tracker output to millimetres.

    One factor for the whole track: the speaker is taken to keep a constant distance from the camera up to the change
    of size that a similarity fit takes out later (`normalise.least_squares` with ``scale=True``).

    Parameters
    ----------
    pixels : MarkerTrack
        Columns x (right), y (down), z (scale of x, negative towards the camera).
    between : (str, str)
        Two markers whose distance is known or assumed, such as the outer corners of the eyes.
    millimetres : float
        That distance.
    frame : int, optional
        Measure in this frame; the default is the median over all frames.
    mirrored : bool
        The pictures were mirrored, so that the speaker's left is on their left.

    Raises
    ------
    InputError
        If a marker is unknown, the two are never seen together, or the distance is not above 0.

    Examples
    --------
    >>> from mien.core.timeline import FrameRate
    >>> picture = MarkerTrack(("right", "left"), [[[100.0, 50.0, 0.0], [160.0, 50.0, 0.0]]], FrameRate.of(25))
    >>> metric = to_millimetres(picture, ("right", "left"))
    >>> metric.mm_per_pixel, metric.track.positions[0, 1].tolist()
    (1.5, [240.0, -75.0, -0.0])
    """
    if not millimetres > 0:
        raise InputError(f"the distance between {between[0]!r} and {between[1]!r} is above 0 mm, not {millimetres}")
    one, other = columns(pixels, between)
    distance = np.linalg.norm(pixels.positions[:, one] - pixels.positions[:, other], axis=1)
    measured = _measured(distance, frame)
    if not measured > 0:
        raise InputError(f"markers {between[0]!r} and {between[1]!r} are never seen apart: no scale can be measured")
    factor = millimetres / measured
    assumption = (
        f"weak perspective; {millimetres:g} mm between {between[0]} and {between[1]} ({measured:.2f} pixels"
        + ("" if frame is None else f" in frame {frame}")
        + f"); pictures {'mirrored' if mirrored else 'not mirrored'}"
    )
    return Metric(scaled(pixels, factor, mirrored), factor, assumption)


def scaled(pixels: MarkerTrack, mm_per_pixel: float, mirrored: bool = False) -> MarkerTrack:
    """The same with a factor that is known, such as that of another take of the session."""
    signs = np.array([-1.0 if mirrored else 1.0, -1.0, -1.0])
    return MarkerTrack(pixels.names, pixels.positions * mm_per_pixel * signs, pixels.rate)


def _measured(distance: NDArray[np.float64], frame: int | None) -> float:
    if frame is not None:
        if not 0 <= frame < len(distance):
            raise InputError(f"frame {frame} is not in a track of {len(distance)} frames")
        return float(distance[frame])
    seen = distance[np.isfinite(distance)]
    return float(np.median(seen)) if seen.size else 0.0
