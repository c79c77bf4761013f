"""How far lips and lids were open: as recorded, and what the face has to show for it.

Least squares over many markers leaves a millimetre here and there, which is nothing on a cheek and everything between
two lips. So the distance across each opening is asked for by itself, and where the recording is shut the face is asked
to be shut, whatever the tracker's own smallest distance is.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.capture.knowledge import Opening, knowledge

__all__ = ["Seen", "openings_of", "wanted"]

Floats = NDArray[np.float64]

_LEAST_SHUT, _USUAL_SHUT = 0.5, 0.25  # of the lid gap at rest: what counts as a blink seen, and the gap of one unseen


@dataclass(frozen=True, eq=False)
class Seen:
    """An opening that a set of markers shows.

    Attributes
    ----------
    opening : Opening
    rows : ndarray, shape (markers,)
        ``rows @ positions[:, opening.axis]`` is the distance across it, mm.
    rest : float
        That distance in the neutral face, as recorded.
    shut : float
        That distance when shut, as recorded.
    """

    opening: Opening
    rows: Floats
    rest: float
    shut: float


def openings_of(
    landmarks: Mapping[int, str], names: Sequence[str], neutral: Floats, frames: Floats
) -> tuple[Seen, ...]:
    """The openings that these markers show.

    Parameters
    ----------
    landmarks : mapping of int to str
        Marker by its number in MediaPipe's face mesh.
    names : sequence of str
        Of the markers, in the order of the arrays.
    neutral : ndarray, shape (markers, 3)
    frames : ndarray, shape (frames, markers, 3)
        Recorded, to see how shut they come.
    """
    place = {name: number for number, name in enumerate(names)}
    found = []
    for opening in knowledge().openings:
        rows, total = np.zeros(len(names)), 0.0
        for upper, lower, weight in opening.pairs:
            ends = [(number, sign) for number, sign in ((upper, 1.0), (lower, -1.0)) if number >= 0]
            if all(landmarks.get(number, "") in place for number, _ in ends):
                for number, sign in ends:
                    rows[place[landmarks[number]]] += sign * weight
                total += weight
        if total == 0.0:
            continue
        rows /= total
        rest, gaps = float(rows @ neutral[:, opening.axis]), frames[:, :, opening.axis] @ rows
        gaps = gaps[np.isfinite(gaps)]
        found.append(Seen(opening, rows, rest, _shut(opening, rest, gaps)))
    return tuple(found)


def _shut(opening: Opening, rest: float, gaps: Floats) -> float:
    if opening.shut_by is None and opening.shut_mm is None:
        return -np.inf
    lowest = float(np.quantile(gaps, 0.005)) if len(gaps) else rest
    if opening.shut_mm is not None:
        return opening.shut_mm
    return lowest if lowest < _LEAST_SHUT * rest else _USUAL_SHUT * rest


def wanted(seen: Seen, gaps: Floats, own_rest: float) -> tuple[Floats, NDArray[np.bool_]]:
    """What the face has to show, as a change from its rest, mm, and the frames in which it is shut.

    Parameters
    ----------
    seen : Seen
    gaps : ndarray, shape (frames,)
        As recorded, in the size of the face.
    own_rest : float
        The face's own opening at rest: 0 for lips, which touch.

    Notes
    -----
    The recorded distance above twice ``shut`` is kept; from there down to ``shut`` it falls to nothing, twice as fast.
    """
    if seen.opening.shut_mm is not None:
        gaps = gaps - min(seen.rest, 0.0)  # landmarks of lips that touch may lie past one another
        above = np.clip(2 * (gaps - seen.shut), 0, None)
        return np.where(gaps < 2 * seen.shut, above, gaps) - own_rest, gaps <= seen.shut
    if seen.opening.shut_by is None:
        return gaps - seen.rest, np.zeros(len(gaps), dtype=bool)
    low, high = 1.05 * seen.shut, 0.5 * (seen.shut + seen.rest)
    change = gaps - seen.rest
    share = np.clip((high - gaps) / max(high - low, 1e-6), 0, 1)
    at_high = high - seen.rest
    falling = at_high + share * (-own_rest - at_high)
    return np.where(gaps < high, falling, change), gaps <= low
