"""Bilabial closures: do the lips shut on P, B and M, and only there?

Conventions
-----------
* The lips are shut in a frame whose lip opening (inner lips, mm) is below `CLOSED` = 0.75 mm.
* A bilabial counts if there is speech on both sides of it: a phone, not a pause, touches it before and after. At the
  edge of a pause the lips may rest shut, which says nothing.
* It is found if a frame with shut lips lies in the phone or within `TOLERANCE` = 50 ms of it.
* Precision is over speech frames (frames inside phones that are no pause): of those with shut lips, the share within
  50 ms of a bilabial that counts. Frames within 50 ms of a bilabial beside a pause are left out of the balance: shut
  lips are right there and are no proof of anything.
* `evaluate` asks as well, phones or none, whether one face's lips are shut when the other's are.
* The same is asked of the recording itself; its own score is the yardstick, since a real speaker leaves some
  bilabials open (in the eyes of a tracker) and shuts the lips now and then without one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.core.timeline import Interval, Tier
from mien.metrics.face_track import FaceTrack
from mien.metrics.mouth import mouth_pair
from mien.metrics.pairing import Pair, frontal

__all__ = [
    "BILABIALS",
    "CLOSED",
    "TOLERANCE",
    "ClosureCounts",
    "closure_counts",
    "evaluate",
    "shut_together",
    "validate",
    "validate_faces",
]

CLOSED = 0.75
"""Millimetres of lip opening below which lips are shut."""
TOLERANCE = 0.05
"""Seconds about a phone within which its closure may fall."""
BILABIALS = frozenset({"P", "B", "M"})
_PAUSES = frozenset({"SIL", ""})
_TOUCHING = 1e-3  # seconds between two phones that are still one stretch of speech

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ClosureCounts:
    """What was counted; counts of several takes add up.

    Attributes
    ----------
    bilabials, found : int
        Bilabials that count, and those with shut lips.
    closed_frames, right_frames : int
        Speech frames with shut lips, and those of them at a bilabial that counts.
    """

    bilabials: int
    found: int
    closed_frames: int
    right_frames: int

    def __add__(self, other: ClosureCounts) -> ClosureCounts:
        return ClosureCounts(
            self.bilabials + other.bilabials,
            self.found + other.found,
            self.closed_frames + other.closed_frames,
            self.right_frames + other.right_frames,
        )

    @property
    def recall(self) -> float:
        """Share of the bilabials that were found; NaN if there was none."""
        return self.found / self.bilabials if self.bilabials else float("nan")

    @property
    def precision(self) -> float:
        """Share of the shut frames that were right; NaN if the lips never shut."""
        return self.right_frames / self.closed_frames if self.closed_frames else float("nan")

    @property
    def f1(self) -> float:
        """Harmonic mean of precision and recall; 0 if the lips never shut, NaN without bilabials."""
        if not self.bilabials:
            return float("nan")
        return 2 * self.recall * self.precision / (self.recall + self.precision) if self.right_frames else 0.0


def validate(opening: Array, times: Array) -> None:
    """Refuse an opening and times that are not both of shape (frames,)."""
    if opening.ndim != 1 or opening.shape != times.shape:
        raise InputError(f"expected one lip opening for each time, got shapes {opening.shape} and {times.shape}")


def closure_counts(
    opening: Array, times: Array, phones: Tier, counted: NDArray[np.bool_] | None = None
) -> ClosureCounts:
    """Count the closures of one take.

    Parameters
    ----------
    opening : ndarray, shape (frames,)
        Lip opening in mm; NaN where it was not seen (such a frame is neither open nor shut).
    times : ndarray, shape (frames,)
        Seconds.
    phones : Tier
        ARPAbet phones without stress, pauses as ``SIL``.
    counted : ndarray of bool, shape (frames,), or None
        Score inside these frames only: bilabials that lie in them whole, shut frames among them.

    Raises
    ------
    InputError
        If the shapes do not fit.

    Examples
    --------
    >>> tier = Tier("phones", (Interval(0.0, 0.1, "AA"), Interval(0.1, 0.2, "M"), Interval(0.2, 0.3, "AA")))
    >>> times = np.arange(0.0, 0.3, 0.04)
    >>> opening = np.where((times > 0.1) & (times < 0.2), 0.2, 6.0)
    >>> closure_counts(opening, times, tier)
    ClosureCounts(bilabials=1, found=1, closed_frames=2, right_frames=2)
    """
    validate(opening, times)
    inside = np.ones(len(times), dtype=bool) if counted is None else counted
    shut = np.nan_to_num(opening, nan=np.inf) < CLOSED
    speech = _within(times, [p for p in phones if p.label not in _PAUSES], 0.0)
    every = [p for p in phones if p.label in BILABIALS]
    counting = [p for p in every if _has_speech_on_both_sides(p, phones)]
    near = _within(times, counting, TOLERANCE)
    beside_pause = _within(times, [p for p in every if p not in counting], TOLERANCE) & ~near
    judged = shut & speech & inside & ~beside_pause
    asked = [p for p in counting if inside[_frames_of(p, times)].all()]
    return ClosureCounts(
        bilabials=len(asked),
        found=sum(bool((shut & _within(times, [p], TOLERANCE)).any()) for p in asked),
        closed_frames=int(judged.sum()),
        right_frames=int((judged & near).sum()),
    )


def _frames_of(phone: Interval, times: Array) -> NDArray[np.int64]:
    """Frames inside a phone; if it is too short to hold one, the frames before and after it."""
    first, after = (int(np.searchsorted(times, instant - 1e-9)) for instant in (phone.start, phone.end))
    first, after = (first, after) if first < after else (first - 1, after + 1)
    return np.arange(max(first, 0), min(after, len(times)))


def _within(times: Array, intervals: list[Interval], margin: float) -> NDArray[np.bool_]:
    """Which instants lie in one of the intervals widened by the margin."""
    held = np.zeros(len(times), dtype=bool)
    for interval in intervals:
        held |= (times >= interval.start - margin - 1e-9) & (times < interval.end + margin + 1e-9)
    return held


def _has_speech_on_both_sides(phone: Interval, phones: Tier) -> bool:
    place = phones.intervals.index(phone)
    if not 0 < place < len(phones) - 1:
        return False
    before, after = phones.intervals[place - 1], phones.intervals[place + 1]
    return (
        before.label not in _PAUSES
        and after.label not in _PAUSES
        and phone.start - before.end < _TOUCHING
        and after.start - phone.end < _TOUCHING
    )


# ------------------------------------------------------------ of two faces in motion


def validate_faces(reference: FaceTrack, estimate: FaceTrack) -> None:
    """Refuse two faces whose inner lips are not both seen.

    Raises
    ------
    InputError
    """
    _openings(reference, estimate, None)


def evaluate(
    reference: FaceTrack, estimate: FaceTrack, *, counted: NDArray[np.bool_] | None = None
) -> dict[str, float]:
    """Score the closures of a mouth against another's.

    Returns
    -------
    dict of str to float
        ``shut_reference``, ``shut_estimate``: share of the frames with shut lips; ``shut_recall``, ``shut_precision``,
        ``shut_f1``: of the frames that the reference (the estimate) shuts, the share within 50 ms of a shut frame of
        the other; where phones are known ``bilabials``, and for the estimate and the ``_reference`` itself
        ``closure_recall``, ``closure_precision``, ``closure_f1``. NaN where there is nothing to ask.

    Raises
    ------
    InputError
        As `validate_faces`.
    """
    pair, one, other = _openings(reference, estimate, counted)
    held = pair.counted
    own, found, others, right = (float(count) for count in shut_together(one, other, held, pair.fps))
    recall, precision = _share(found, own), _share(right, others)
    scores = {
        "shut_reference": own / float(held.sum()),
        "shut_estimate": others / float(held.sum()),
        "shut_recall": recall,
        "shut_precision": precision,
        "shut_f1": _f1(recall, precision),
    }
    phones = reference.phones or estimate.phones
    if phones is None:
        return scores
    for ending, opening in (("", other), ("_reference", one)):
        counts = closure_counts(np.where(held, opening, np.nan), pair.times, phones, held)
        scores["bilabials"] = float(counts.bilabials)
        scores |= {
            f"closure_recall{ending}": counts.recall,
            f"closure_precision{ending}": counts.precision,
            f"closure_f1{ending}": counts.f1,
        }
    return scores


def shut_together(reference: Array, estimate: Array, counted: NDArray[np.bool_], fps: float) -> Array:
    """Are the lips of one face shut when the other's are? Whatever phones say.

    Parameters
    ----------
    reference, estimate : ndarray, shape (frames,)
        Lip openings, mm.
    counted : ndarray of bool, shape (frames,)
    fps : float

    Returns
    -------
    ndarray, shape (4,)
        Frames that the reference shuts, those of them within `TOLERANCE` of a shut one of the estimate; the same the
        other way round.

    Examples
    --------
    >>> one, other = np.array([5.0, 0.2, 0.2, 5.0, 5.0, 5.0, 5.0]), np.array([5.0, 5.0, 5.0, 0.1, 5.0, 5.0, 0.1])
    >>> shut_together(one, other, np.ones(7, dtype=bool), 25.0).tolist()
    [2.0, 1.0, 2.0, 1.0]
    """
    shut = [counted & (np.nan_to_num(opening, nan=np.inf) < CLOSED) for opening in (reference, estimate)]
    near = [_widened(each, fps) for each in shut]
    pairs = ((shut[0], near[1]), (shut[1], near[0]))
    return np.array([float(count) for one, other in pairs for count in (one.sum(), (one & other).sum())])


def _openings(
    reference: FaceTrack, estimate: FaceTrack, counted: NDArray[np.bool_] | None
) -> tuple[Pair, Array, Array]:
    pair, sites = mouth_pair(reference, estimate, counted)
    if not sites.inner:
        raise InputError("the inner lips (2.2 and 2.3) are not among the landmarks that both have")
    return pair, frontal(pair.reference, *sites.opening), frontal(pair.estimate, *sites.opening)


def _widened(shut: NDArray[np.bool_], fps: float) -> NDArray[np.bool_]:
    """Frames within `TOLERANCE` of a shut one."""
    reach = int(np.floor(TOLERANCE * fps + 1e-6))
    return np.asarray(np.convolve(shut, np.ones(2 * reach + 1), mode="same") > 0)


def _share(some: float, of: float) -> float:
    return some / of if of else float("nan")


def _f1(recall: float, precision: float) -> float:
    if np.isnan(recall):
        return float("nan")
    return 2 * recall * precision / (recall + precision) if recall + np.nan_to_num(precision) > 0 else 0.0
