"""How much of a recording shows no face: a tracker that lost it, a hand before it, a head turned away.

What was lost is filled when a recording is cleaned, and then looks like motion. A take of which more than `MOST_LOST`
was lost is therefore refused; what was lost of the others stands in their ``source["lost"]``.
"""

from __future__ import annotations

import numpy as np

from mien.core.errors import InputError
from mien.core.tracks import MarkerTrack
from mien.corpus.take import Take

__all__ = ["MOST_LOST", "check_face", "frames_lost", "share_lost"]

MOST_LOST = 0.2
"""Share of the frames without a face above which a recording is refused."""
_MOST_MARKERS = 0.5  # share of the markers that must be missing for the face to count as lost


def frames_lost(track: MarkerTrack) -> int:
    """Frames of a recording, as its files have it, in which half of the markers or more were not seen.

    Markers that are never seen do not count: they are dropped.
    """
    seen = np.asarray(np.isfinite(track.positions).all(axis=2))
    kept = seen[:, seen.any(axis=0)]
    return int((kept.mean(axis=1) <= _MOST_MARKERS).sum()) if kept.shape[1] else len(track)


def check_face(track: MarkerTrack, source: str) -> int:
    """Frames without a face (`frames_lost`).

    Raises
    ------
    InputError
        If they are more than `MOST_LOST` of all.
    """
    lost = frames_lost(track)
    if lost > MOST_LOST * len(track):
        raise InputError(
            f"{source}: the face was lost in {lost} of {len(track)} frames ({lost / len(track):.0%}; at most "
            f"{MOST_LOST:.0%}): is it in the picture, upright, lit and uncovered? Record it again, or cut it"
        )
    return lost


def share_lost(take: Take) -> float:
    """Share of a take's frames in which the face was lost before it was filled, 0..1.

    Takes imported before this was counted say only how many marker positions were filled: that share is given.
    """
    counted = take.source.get("lost", "")
    if counted:
        return float(counted) / max(len(take.markers), 1)
    dropped = len(take.source.get("dropped", "").split())
    positions = len(take.markers) * max(len(take.markers.names) - dropped, 1)
    return min(float(take.source.get("filled") or 0) / max(positions, 1), 1.0)
